/* SPDX-License-Identifier: MIT */
#ifndef LCOR_PYTHON_MEAN_HPP
#define LCOR_PYTHON_MEAN_HPP

#include "array.hpp"

#include <mutex>

/* lcor_mean behind a lock, since Python threads may share one. */
class Mean
{
  public:
    Mean() { lcor_mean_init(&value); }
    Mean(const Mean &other)
    {
        const std::lock_guard<std::mutex> lock(other.mutex);
        value = other.value;
    }
    Mean &operator=(const Mean &) = delete;

    void add(nb::handle r, nb::handle weights);
    void merge(const Mean &other);
    double get(lcor_mean_method method) const;
    double error(lcor_mean_method method) const;
    void refine(lcor_mean_method method);
    nb::bytes state() const;
    void set_state(nb::bytes state);

    lcor_mean value;
    mutable std::mutex mutex;
};

#endif
