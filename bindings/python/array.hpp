/* SPDX-License-Identifier: MIT */
/* Arrays of the caller through the buffer protocol: any strides, no copy, their type checked. */
#ifndef LCOR_PYTHON_ARRAY_HPP
#define LCOR_PYTHON_ARRAY_HPP

#include <lcor/lcor.h>

#include <nanobind/nanobind.h>

#include <initializer_list>
#include <string>

namespace nb = nanobind;
using namespace nb::literals;

/* A status that is not LCOR_OK becomes a Python exception with the library's own text. */
void check(lcor_status status, const lcor_error &error);

constexpr int max_dims = 32;

size_t sample_size(lcor_sample type);

/* Lengths of the dimensions, first to last. */
struct Shape {
    int n = 0;
    Py_ssize_t dim[max_dims] = {};

    size_t count() const;
    /* Grow to the broadcast of both by numpy's rules; 0 when they do not fit. */
    bool broadcast(const Shape &other);
    bool operator==(const Shape &other) const;
    std::string text() const;
};

/* Which sample types an argument may have. */
enum class Kind { colour, real };

/* A Py_buffer that is released. */
struct Buffer {
    Py_buffer view = {};
    bool held = false;

    Buffer() = default;
    Buffer(Buffer &&other) noexcept : view(other.view), held(other.held) { other.held = false; }
    ~Buffer()
    {
        if (held)
            PyBuffer_Release(&view);
    }
};

/* One array of the caller, held as long as this lives. Made and destroyed with the GIL. */
class Array
{
  public:
    /* An input: a buffer is taken as it is, anything else goes through numpy.asarray. A
     * Python number, or a tuple or list of three floats, is copied without numpy's help. Raises
     * TypeError for other sample types, naming the fix. */
    Array(nb::handle source, const char *name, Kind kind);
    /* An output: writable, and of exactly this shape. */
    static Array output(nb::handle target, const char *name, Kind kind, const Shape &wanted);
    Array(Array &&other) noexcept;
    Array(const Array &) = delete;
    Array &operator=(const Array &) = delete;

    const char *name;
    nb::object object;
    lcor_sample type = LCOR_F64;
    char *data = nullptr;
    Shape shape;
    Py_ssize_t stride[max_dims] = {}; /* bytes */

    /* Drop the last dimension, which must hold the three channels; its stride is returned. */
    Py_ssize_t take_channels();
    void give_channels() { shape.n++; } /* undo it */

  private:
    Array(const char *array_name, int) : name(array_name) {}
    void acquire(nb::handle source, Kind kind, bool writable);
    bool take_numbers(nb::handle source, Kind kind);

    Buffer buffer_;
    double inside_[3] = {}; /* a Python number, or three of them, lie here */
};

/* A fresh numpy array and the buffer to fill it through. */
Array new_array(const Shape &shape, lcor_sample type);

/* Raises ValueError when `out` shares memory with `in` in any way the row calls do not allow: as
 * the very same samples (`same_allowed`) is fine, anything else is not. */
void check_overlap(const Array &out, const Array &in, bool same_allowed);

/* A number for a 0-dimensional result, else the array. */
nb::object result(const Array &array);

#endif
