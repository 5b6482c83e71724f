/* SPDX-License-Identifier: MIT */
#ifndef LCOR_PYTHON_SCENE_HPP
#define LCOR_PYTHON_SCENE_HPP

#include "array.hpp"

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>

using Vec3 = std::array<double, 3>;

/* A scene, shared by its solutions and views. */
struct SceneHandle {
    lcor_scene *scene = nullptr;
    std::atomic<bool> committed{false};
    std::mutex committing;
    int users = 0; /* calls without the GIL that read it; changed with the GIL only */

    SceneHandle();
    SceneHandle(const SceneHandle &) = delete;
    SceneHandle &operator=(const SceneHandle &) = delete;
    ~SceneHandle() { lcor_scene_free(scene); }
};

/* Marks an object as being read while the GIL is released. */
class InUse
{
  public:
    explicit InUse(int &users) : users_(users) { users_++; }
    InUse(const InUse &) = delete;
    InUse &operator=(const InUse &) = delete;
    ~InUse() { users_--; }

  private:
    int &users_;
};

struct Scene {
    std::shared_ptr<SceneHandle> handle = std::make_shared<SceneHandle>();
};

/* The caller's threads: `count` of them, made for each run. */
class Threads
{
  public:
    explicit Threads(int count) : count_(count)
    {
        if (count < 1)
            throw nb::value_error("threads must be at least 1");
    }
    lcor_parallel parallel();

  private:
    static void run(void *user, size_t n, void (*task)(void *, size_t), void *arg);
    int count_;
};

/* A Python callable as lcor_progress; Ctrl-C and exceptions cancel the call. */
class Progress
{
  public:
    explicit Progress(nb::handle callback) : callback_(nb::borrow(callback)) {}
    lcor_progress progress() { return {report, this}; }

  private:
    static int report(void *user, double done);
    nb::object callback_;
};

/* A solution and what its later updates still call. */
struct Solution {
    std::shared_ptr<SceneHandle> scene;
    Threads threads;
    Progress progress;
    lcor_solution *solution = nullptr;
    int users = 0;

    Solution(const Scene &of, int thread_count, nb::handle callback)
        : scene(of.handle), threads(thread_count), progress(callback)
    {
    }
    Solution(const Solution &) = delete;
    Solution &operator=(const Solution &) = delete;
    ~Solution() { lcor_solution_free(solution); }
};

#endif
