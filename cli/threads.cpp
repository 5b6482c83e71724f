/* SPDX-License-Identifier: MIT */
#include "cli.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>

namespace cli
{

/* Of the machine, or less where the process is held to less (`ulimit -v`). */
static double usable_memory()
{
    const double machine =
        static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
    rlimit addresses{};
    if (getrlimit(RLIMIT_AS, &addresses) != 0 || addresses.rlim_cur == RLIM_INFINITY)
        return machine;
    return std::min(machine, static_cast<double>(addresses.rlim_cur));
}

void check_memory(double bytes, const std::string &what, const char *advice)
{
    constexpr double giga = 1e9;
    const double has = usable_memory();
    if (bytes > has && has > 0.0)
        fail(Exit::input, "%s needs about %.1f GB of memory and there are %.1f; %s", what.c_str(),
             bytes / giga, has / giga, advice);
}

/* Workers sleep between jobs; the calling thread takes part in every one. */
struct Threads::Pool {
    std::mutex mutex;
    std::condition_variable wake, done;
    std::vector<std::thread> workers;
    const std::function<void(size_t)> *task = nullptr;
    size_t size = 0;
    std::atomic<size_t> next{0};
    size_t busy = 0;
    unsigned job = 0;
    bool stop = false;
    std::exception_ptr error;

    void take()
    {
        for (size_t i = next++; i < size; i = next++) {
            try {
                (*task)(i);
            } catch (...) {
                const std::lock_guard<std::mutex> lock(mutex);
                if (!error)
                    error = std::current_exception();
                next = size;
            }
        }
    }

    void work()
    {
        unsigned seen = 0;
        std::unique_lock<std::mutex> lock(mutex);
        for (;;) {
            wake.wait(lock, [&] { return stop || job != seen; });
            if (stop)
                return;
            seen = job;
            lock.unlock();
            take();
            lock.lock();
            if (--busy == 0)
                done.notify_one();
        }
    }
};

Threads::Threads(int count) : pool_(std::make_unique<Pool>())
{
    const unsigned wanted = count > 0 ? static_cast<unsigned>(count)
                                      : std::max(1U, std::thread::hardware_concurrency());
    for (unsigned i = 1; i < std::min(wanted, 256U); i++)
        pool_->workers.emplace_back([this] { pool_->work(); });
}

Threads::~Threads()
{
    {
        const std::lock_guard<std::mutex> lock(pool_->mutex);
        pool_->stop = true;
    }
    pool_->wake.notify_all();
    for (std::thread &worker : pool_->workers)
        worker.join();
}

int Threads::count() const { return static_cast<int>(pool_->workers.size()) + 1; }

void Threads::run(size_t n, const std::function<void(size_t)> &task)
{
    if (n == 0)
        return;
    {
        const std::lock_guard<std::mutex> lock(pool_->mutex);
        pool_->task = &task;
        pool_->size = n;
        pool_->next = 0;
        pool_->error = nullptr;
        pool_->busy = pool_->workers.size();
        pool_->job++;
    }
    pool_->wake.notify_all();
    pool_->take();
    std::unique_lock<std::mutex> lock(pool_->mutex);
    pool_->done.wait(lock, [&] { return pool_->busy == 0; });
    if (pool_->error)
        std::rethrow_exception(pool_->error);
}

lcor_parallel Threads::parallel()
{
    return {[](void *user, size_t n, void (*task)(void *arg, size_t i), void *arg) {
                static_cast<Threads *>(user)->run(n, [=](size_t i) { task(arg, i); });
            },
            this};
}

} // namespace cli
