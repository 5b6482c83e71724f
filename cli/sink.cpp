/* SPDX-License-Identifier: MIT */
#include "sink.h"
#include "cli.h"

#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace cli
{

Sink::Sink(const std::string &path, const std::string &name)
    : IOProxy(path, Write), name_(name), file_(open(path.c_str(), O_RDWR | O_CLOEXEC))
{
    if (file_ < 0) /* devices and pipes may be for writing only */
        file_ = open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (file_ < 0)
        fail_file("write", name_, errno);
}

Sink::~Sink() { ::close(file_); }

bool Sink::seek(int64_t offset)
{
    if (lseek(file_, offset, SEEK_SET) < 0)
        return false;
    m_pos = offset;
    return true;
}

size_t Sink::read(void *buffer, size_t size)
{
    const ssize_t n = ::read(file_, buffer, size);
    m_pos += n > 0 ? n : 0;
    return n > 0 ? static_cast<size_t>(n) : 0;
}

size_t Sink::write(const void *buffer, size_t size)
{
    const char *const bytes = static_cast<const char *>(buffer);
    size_t done = 0;
    while (done < size && errno_ == 0) {
        const ssize_t n = ::write(file_, bytes + done, size - done);
        if (n >= 0)
            done += static_cast<size_t>(n);
        else if (errno != EINTR)
            errno_ = errno;
    }
    m_pos += static_cast<int64_t>(done);
    return done;
}

size_t Sink::size() const
{
    struct stat info = {};
    return fstat(file_, &info) == 0 ? static_cast<size_t>(info.st_size) : 0;
}

void Sink::check() const
{
    if (errno_ != 0)
        fail_file("write", name_, errno_);
}

} // namespace cli
