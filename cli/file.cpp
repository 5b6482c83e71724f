/* SPDX-License-Identifier: MIT */
#include "cli.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace cli
{

namespace
{

/* Temporary files that a signal handler has to remove: fixed places, since it may not allocate. */
struct Slot {
    std::atomic<bool> claimed{false}, armed{false};
    char path[PATH_MAX];
};
Slot slots[64];

/* Also when a picture library ends the program by itself, as libjpeg does. */
extern "C" void remove_temporaries()
{
    for (Slot &slot : slots)
        if (slot.armed.load())
            unlink(slot.path);
}

extern "C" void on_signal(int number)
{
    remove_temporaries();
    /* The shell wants to see 128 + the signal's number: 130 for Ctrl-C. */
    _exit(128 + number);
}

int arm(const std::string &path)
{
    for (int i = 0; i < static_cast<int>(std::size(slots)); i++) {
        if (slots[i].claimed.exchange(true))
            continue;
        std::memcpy(slots[i].path, path.c_str(), path.size() + 1);
        slots[i].armed = true;
        return i;
    }
    fail(Exit::failed, "too many output files at once");
}

void disarm(int slot)
{
    slots[slot].armed = false;
    slots[slot].claimed = false;
}

/* A symbolic link stays and its target is replaced. */
std::string resolve_link(const std::string &path)
{
    char *const real = realpath(path.c_str(), nullptr);
    std::string target = real ? real : path;
    std::free(real);
    return target;
}

void sync_path(const std::string &path, const std::string &name, int flags)
{
    const int fd = open(path.c_str(), flags | O_CLOEXEC);
    if (fd < 0)
        fail_file("sync", name, errno);
    const int error = fsync(fd) == 0 ? 0 : errno;
    close(fd);
    /* Some file systems cannot sync a folder; the rename is atomic there too. */
    if (error != 0 && error != EINVAL && error != ENOTSUP)
        fail_file("write", name, error);
}

std::string folder_of(const std::string &path)
{
    const size_t slash = path.rfind('/');
    return slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
}

} // namespace

void fail_file(const char *what, const std::string &path, int error)
{
    const bool denied = error == EACCES || error == EPERM || error == EROFS;
    const char *hint = "";
    if (error == ENOSPC || error == EDQUOT)
        hint = "; free some space and run it again";
    else if (denied)
        hint = "; choose a folder you may write to";
    else if (error == ENOENT || error == ENOTDIR)
        hint = "; its folder does not exist, make it first";
    fail(denied ? Exit::permission : Exit::failed, "cannot %s '%s': %s%s", what, path.c_str(),
         std::strerror(error), hint);
}

void handle_signals()
{
    std::atexit(remove_temporaries);
    struct sigaction action = {};
    action.sa_handler = on_signal;
    sigfillset(&action.sa_mask);
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction old = {};
        /* nohup and shells in the background ignore some of these: leave them so. */
        if (sigaction(number, nullptr, &old) == 0 && old.sa_handler != SIG_IGN)
            sigaction(number, &action, nullptr);
    }
}

OutputFile::OutputFile(std::string path) : path_(std::move(path)), target_(resolve_link(path_))
{
    struct stat info = {};
    const bool exists = stat(target_.c_str(), &info) == 0;
    if (exists && S_ISDIR(info.st_mode))
        fail(Exit::usage, "'%s' is a folder; name a file in it", path_.c_str());
    if (exists && !S_ISREG(info.st_mode)) {
        direct_ = true;
        temporary_ = target_;
        return;
    }
    if (exists && access(target_.c_str(), W_OK) != 0)
        fail_file("write", path_, errno);
    /* Writers of pictures look at the extension, so the temporary file has the same one. */
    const std::string folder = folder_of(target_);
    const std::string name = target_.substr(target_.rfind('/') + 1);
    const size_t dot = name.rfind('.');
    const std::string extension = dot == std::string::npos ? "" : name.substr(dot);
    temporary_ = folder + "/.lcor-XXXXXX" + extension;
    if (temporary_.size() >= PATH_MAX)
        fail_file("write", path_, ENAMETOOLONG);
    const int fd = mkstemps(temporary_.data(), static_cast<int>(extension.size()));
    if (fd < 0)
        fail_file("write", path_, errno);
    slot_ = arm(temporary_);
    const mode_t mask = umask(0);
    umask(mask);
    const int status = fchmod(fd, exists ? info.st_mode & 07777 : 0666 & ~mask);
    close(fd);
    if (status != 0)
        fail_file("write", path_, errno);
}

OutputFile::~OutputFile()
{
    if (slot_ < 0)
        return;
    unlink(temporary_.c_str());
    disarm(slot_);
}

void OutputFile::commit()
{
    if (direct_)
        return;
    sync_path(temporary_, path_, O_RDONLY);
    if (rename(temporary_.c_str(), target_.c_str()) != 0)
        fail_file("write", path_, errno);
    disarm(slot_);
    slot_ = -1;
    sync_path(folder_of(target_), path_, O_RDONLY | O_DIRECTORY);
}

namespace
{

/* Up to `size` bytes. */
std::string read_bytes(const std::string &path, uint64_t size, Exit missing)
{
    const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        fail(errno == EACCES ? Exit::permission : missing, "cannot read '%s': %s", path.c_str(),
             std::strerror(errno));
    std::string bytes;
    struct stat info = {};
    if (fstat(fd, &info) == 0 && S_ISREG(info.st_mode))
        bytes.reserve(
            static_cast<size_t>(std::min<uint64_t>(static_cast<uint64_t>(info.st_size), size)));
    char chunk[65536];
    int error = 0;
    while (bytes.size() < size && error == 0) {
        const ssize_t n = read(fd, chunk, std::min<uint64_t>(sizeof chunk, size - bytes.size()));
        if (n == 0)
            break;
        if (n > 0)
            bytes.append(chunk, static_cast<size_t>(n));
        else if (errno != EINTR)
            error = errno;
    }
    close(fd);
    if (error != 0)
        fail(missing, "cannot read '%s': %s", path.c_str(), std::strerror(error));
    return bytes;
}

} // namespace

std::string read_start(const std::string &path, size_t size)
{
    return read_bytes(path, size, Exit::input);
}

std::string read_file(const std::string &path, uint64_t limit, Exit missing)
{
    std::string bytes = read_bytes(path, limit + 1, missing);
    if (bytes.size() > limit)
        fail(missing, "'%s' is larger than the %llu bytes lcor takes", path.c_str(),
             static_cast<unsigned long long>(limit));
    return bytes;
}

void check_output(const std::string &path) { const OutputFile trial(path); }

void write_file(const std::string &path, const std::string &bytes)
{
    OutputFile file(path);
    const int fd = open(file.temporary().c_str(), O_WRONLY | O_CLOEXEC);
    if (fd < 0)
        fail_file("write", path, errno);
    size_t done = 0;
    int error = 0;
    while (done < bytes.size() && error == 0) {
        const ssize_t n = write(fd, bytes.data() + done, bytes.size() - done);
        if (n >= 0)
            done += static_cast<size_t>(n);
        else if (errno != EINTR)
            error = errno;
    }
    if (close(fd) != 0 && error == 0)
        error = errno;
    if (error != 0)
        fail_file("write", path, error);
    file.commit();
}

} // namespace cli
