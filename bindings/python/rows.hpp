/* SPDX-License-Identifier: MIT */
/* Arrays as rows of the library: the last dimension is the row, the ones before it are counted
 * through, dimensions of length 1 are repeated. A row that lies as the library reads it is handed
 * over where it is; any other is copied into a scratch row. Everything here runs without the GIL.
 */
#ifndef LCOR_PYTHON_ROWS_HPP
#define LCOR_PYTHON_ROWS_HPP

#include "array.hpp"

#include <cstddef>
#include <optional>
#include <vector>

/* Where the rows of an array start when it is broadcast to a shape. */
class Lane
{
  public:
    Lane(const Array &array, const Shape &shape);
    char *row(size_t index) const;
    Py_ssize_t across = 0; /* bytes from one element of a row to the next */

  private:
    char *start_;
    Shape shape_;
    Py_ssize_t step_[max_dims] = {};
};

/* Rows of a shape: how many, and how long. */
size_t row_count(const Shape &shape);
size_t row_length(const Shape &shape);

/* float32 or float64 values, one an element. */
class ValueRows
{
  public:
    ValueRows(const Array &array, const Shape &shape, lcor_sample wanted);
    const void *get(size_t row);

  private:
    Lane lane_;
    lcor_sample have_, want_;
    size_t n_;
    bool direct_;
    const char *last_ = nullptr; /* what the scratch row holds: a scalar is spread only once */
    std::vector<double> scratch_;
};

/* Pixels of three channels. `layout` is how get and put rows lie, in samples. */
class PixelRows
{
  public:
    PixelRows(const Array &array, Py_ssize_t channel_stride, const Shape &shape,
              bool packed_only = false);
    const void *get(size_t row); /* to read */
    void *target(size_t row);    /* to write, followed by put */
    void put(size_t row);

    lcor_layout layout = {3, 1};

  private:
    Lane lane_;
    Py_ssize_t channel_;
    size_t item_, n_;
    bool direct_;
    std::vector<double> scratch_;
};

/* Three float64 numbers an element: points, normals, colours. */
class TripleRows
{
  public:
    TripleRows(const Array &array, Py_ssize_t channel_stride, const Shape &shape);
    const double *get(size_t row);

  private:
    PixelRows pixels_;
    bool f32_;
    std::vector<double> scratch_;
};

#endif
