/* SPDX-License-Identifier: MIT */
#include "rows.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>

size_t row_length(const Shape &shape)
{
    return shape.n ? static_cast<size_t>(shape.dim[shape.n - 1]) : 1;
}

size_t row_count(const Shape &shape)
{
    Shape outer = shape;
    outer.n = shape.n ? shape.n - 1 : 0;
    return outer.count();
}

Lane::Lane(const Array &array, const Shape &shape) : start_(array.data), shape_(shape)
{
    const int before = shape.n - array.shape.n; /* dimensions the array lacks */
    for (int d = before; d < shape.n; d++)
        step_[d] = array.shape.dim[d - before] == 1 ? 0 : array.stride[d - before];
    across = shape.n ? step_[shape.n - 1] : 0;
}

char *Lane::row(size_t index) const
{
    char *p = start_;
    for (int d = shape_.n - 2; d >= 0; d--) {
        const auto length = static_cast<size_t>(shape_.dim[d]);
        p += static_cast<Py_ssize_t>(index % length) * step_[d];
        index /= length;
    }
    return p;
}

static bool aligned(const void *p, size_t item)
{
    return reinterpret_cast<uintptr_t>(p) % item == 0;
}

ValueRows::ValueRows(const Array &array, const Shape &shape, lcor_sample wanted)
    : lane_(array, shape), have_(array.type), want_(wanted), n_(row_length(shape))
{
    const size_t item = sample_size(have_);
    bool steps_aligned = true;
    for (int d = 0; d < array.shape.n; d++)
        steps_aligned = steps_aligned && array.stride[d] % static_cast<Py_ssize_t>(item) == 0;
    direct_ = have_ == want_ && steps_aligned && aligned(array.data, item) &&
              (n_ == 1 || lane_.across == static_cast<Py_ssize_t>(item));
    if (!direct_)
        scratch_.resize(n_);
}

template <typename From, typename To>
static void convert(const char *from, Py_ssize_t step, size_t n, To *to)
{
    for (size_t i = 0; i < n; i++, from += step) {
        From value;
        std::memcpy(&value, from, sizeof value);
        to[i] = static_cast<To>(value);
    }
}

const void *ValueRows::get(size_t row)
{
    const char *from = lane_.row(row);
    if (direct_)
        return from;
    if (from != last_) {
        auto *f32 = reinterpret_cast<float *>(scratch_.data());
        if (want_ == LCOR_F64 && have_ == LCOR_F64)
            convert<double>(from, lane_.across, n_, scratch_.data());
        else if (want_ == LCOR_F64)
            convert<float>(from, lane_.across, n_, scratch_.data());
        else if (have_ == LCOR_F32)
            convert<float>(from, lane_.across, n_, f32);
        else
            convert<double>(from, lane_.across, n_, f32);
        last_ = from;
    }
    return scratch_.data();
}

/* Rows can be handed over when their pixels lie apart, going up. */
static bool fits(const Array &array, Py_ssize_t channel, Py_ssize_t across, size_t n, bool packed,
                 lcor_layout &layout)
{
    const auto item = static_cast<Py_ssize_t>(sample_size(array.type));
    if (!aligned(array.data, sample_size(array.type)))
        return false;
    for (int d = 0; d < array.shape.n; d++)
        if (array.stride[d] % item)
            return false;
    if (channel % item)
        return false;
    const Py_ssize_t c = channel / item, p = across / item, length = static_cast<Py_ssize_t>(n);
    if (c == 1 && (p == 3 || length == 1))
        return true; /* packed: the layout we start with */
    const bool interleaved = c >= 1 && p > 2 * c;
    const bool planar = p >= 1 && c > (length - 1) * p;
    if (packed || !(interleaved || planar))
        return false;
    layout = {static_cast<size_t>(p), static_cast<size_t>(c)};
    return true;
}

PixelRows::PixelRows(const Array &array, Py_ssize_t channel_stride, const Shape &shape,
                     bool packed_only)
    : lane_(array, shape), channel_(channel_stride), item_(sample_size(array.type)),
      n_(row_length(shape)),
      direct_(fits(array, channel_stride, lane_.across, n_, packed_only, layout))
{
    if (!direct_)
        scratch_.resize((3 * n_ * item_ + sizeof(double) - 1) / sizeof(double));
}

const void *PixelRows::get(size_t row)
{
    const char *from = lane_.row(row);
    if (direct_)
        return from;
    char *to = reinterpret_cast<char *>(scratch_.data());
    for (size_t i = 0; i < n_; i++, from += lane_.across)
        for (int k = 0; k < 3; k++, to += item_)
            std::memcpy(to, from + k * channel_, item_);
    return scratch_.data();
}

void *PixelRows::target(size_t row)
{
    return direct_ ? static_cast<void *>(lane_.row(row)) : scratch_.data();
}

void PixelRows::put(size_t row)
{
    if (direct_)
        return;
    char *to = lane_.row(row);
    const char *from = reinterpret_cast<const char *>(scratch_.data());
    for (size_t i = 0; i < n_; i++, to += lane_.across)
        for (int k = 0; k < 3; k++, from += item_)
            std::memcpy(to + k * channel_, from, item_);
}

TripleRows::TripleRows(const Array &array, Py_ssize_t channel_stride, const Shape &shape)
    : pixels_(array, channel_stride, shape, true), f32_(array.type == LCOR_F32),
      scratch_(f32_ ? 3 * row_length(shape) : 0)
{
}

const double *TripleRows::get(size_t row)
{
    const void *from = pixels_.get(row);
    if (!f32_)
        return static_cast<const double *>(from);
    const auto *values = static_cast<const float *>(from);
    std::copy(values, values + scratch_.size(), scratch_.begin());
    return scratch_.data();
}
