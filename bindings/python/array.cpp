/* SPDX-License-Identifier: MIT */
#include "array.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <new>
#include <utility>

void check(lcor_status status, const lcor_error &error)
{
    switch (status) {
    case LCOR_OK: return;
    case LCOR_ERR_NOMEM: throw std::bad_alloc();
    case LCOR_ERR_FORMAT:
        PyErr_SetString(nb::module_::import_("lcor._errors").attr("FormatError").ptr(), error.text);
        throw nb::python_error();
    case LCOR_ERR_CANCELLED:
        if (!PyErr_Occurred()) /* else: what the progress callback raised */
            PyErr_SetString(nb::module_::import_("lcor._errors").attr("Cancelled").ptr(),
                            error.text);
        throw nb::python_error();
    case LCOR_ERR_ARG:
    case LCOR_ERR_DOMAIN: break;
    }
    throw nb::value_error(error.text);
}

size_t sample_size(lcor_sample type)
{
    switch (type) {
    case LCOR_F32: return sizeof(float);
    case LCOR_F64: return sizeof(double);
    case LCOR_U8: return sizeof(uint8_t);
    case LCOR_U16: return sizeof(uint16_t);
    }
    return 0;
}

size_t Shape::count() const
{
    size_t product = 1;
    for (int d = 0; d < n; d++)
        product *= static_cast<size_t>(dim[d]);
    return product;
}

bool Shape::broadcast(const Shape &other)
{
    Shape wide;
    wide.n = std::max(n, other.n);
    for (int d = 1; d <= wide.n; d++) {
        const Py_ssize_t a = d <= n ? dim[n - d] : 1;
        const Py_ssize_t b = d <= other.n ? other.dim[other.n - d] : 1;
        if (a != b && a != 1 && b != 1)
            return false;
        wide.dim[wide.n - d] = a == 1 ? b : a;
    }
    *this = wide;
    return true;
}

bool Shape::operator==(const Shape &other) const
{
    return n == other.n && std::equal(dim, dim + n, other.dim);
}

std::string Shape::text() const
{
    std::string text = "(";
    for (int d = 0; d < n; d++)
        text += (d ? ", " : "") + std::to_string(dim[d]);
    return text + (n == 1 ? ",)" : ")");
}

static nb::object numpy(const char *function)
{
    return nb::module_::import_("numpy").attr(function);
}

/* What to do about a sample type the library does not know. */
static std::string refusal(const char *name, nb::handle array, Kind kind)
{
    const nb::object dtype = numpy("asarray")(array).attr("dtype");
    const std::string type = nb::str(dtype).c_str();
    const std::string number = nb::str(dtype.attr("kind")).c_str();
    const std::string what = std::string(name) + " has samples of type " + type;
    const bool native = nb::cast<bool>(dtype.attr("isnative"));
    const auto size = nb::cast<int>(dtype.attr("itemsize"));
    const bool known_size = number == "f" ? size == 4 || size == 8 : number == "u" && size == 2;
    if (!native && known_size && (number == "f" || kind == Kind::colour))
        return what + ", another machine's byte order: convert them with " + name + ".astype(" +
               name + ".dtype.newbyteorder('='))";
    if (number == "f" || (kind == Kind::real && (number == "i" || number == "u" || number == "b")))
        return what + ": convert them, for example " + name + ".astype(numpy.float32)";
    if (number == "i" || number == "u")
        return what + ", whose scale is not known: convert them, for example " + name +
               ".astype(numpy.uint8) if white is 255, or " + name + " / 4095 if it is 4095";
    return what + (kind == Kind::colour
                       ? ": pass float32, float64 (0..1), uint8 (0..255) or uint16 (0..65535)"
                       : ": pass float32 or float64");
}

static bool known(const char *format, Kind kind, lcor_sample &type)
{
    if (!format)
        format = "B";
    if (*format == '@' || *format == '=')
        format++;
    if (format[0] == '\0' || format[1] != '\0')
        return false;
    switch (format[0]) {
    case 'f': type = LCOR_F32; return true;
    case 'd': type = LCOR_F64; return true;
    case 'B': type = LCOR_U8; return kind == Kind::colour;
    case 'H': type = LCOR_U16; return kind == Kind::colour;
    default: return false;
    }
}

void Array::acquire(nb::handle source, Kind kind, bool writable)
{
    object = nb::borrow(source);
    if (PyObject_GetBuffer(source.ptr(), &buffer_.view,
                           writable ? PyBUF_RECORDS : PyBUF_RECORDS_RO)) {
        PyErr_Clear(); /* a read-only output, or a numpy type without a buffer format */
        if (writable)
            throw nb::value_error(
                (std::string(name) + " cannot be written: pass a writable array").c_str());
        throw nb::type_error(refusal(name, source, kind).c_str());
    }
    buffer_.held = true;
    if (buffer_.view.ndim > max_dims)
        throw nb::value_error((std::string(name) + " has more than 32 dimensions").c_str());
    if (!known(buffer_.view.format, kind, type))
        throw nb::type_error(refusal(name, source, kind).c_str());
    data = static_cast<char *>(buffer_.view.buf);
    shape.n = buffer_.view.ndim;
    std::copy(buffer_.view.shape, buffer_.view.shape + buffer_.view.ndim, shape.dim);
    std::copy(buffer_.view.strides, buffer_.view.strides + buffer_.view.ndim, stride);
}

bool Array::take_numbers(nb::handle source, Kind kind)
{
    PyObject *p = source.ptr();
    if (PyFloat_CheckExact(p) || (kind == Kind::real && PyLong_CheckExact(p))) {
        inside_[0] = PyFloat_AsDouble(p);
        if (inside_[0] == -1.0 && PyErr_Occurred())
            throw nb::python_error();
    } else if ((PyTuple_CheckExact(p) || PyList_CheckExact(p)) && PySequence_Size(p) == 3) {
        for (Py_ssize_t i = 0; i < 3; i++) {
            const nb::object item = nb::steal(PySequence_GetItem(p, i));
            if (!item.is_valid() || !PyFloat_CheckExact(item.ptr()))
                return false;
            inside_[i] = PyFloat_AsDouble(item.ptr());
        }
        shape.n = 1;
        shape.dim[0] = 3;
        stride[0] = sizeof(double);
    } else {
        return false;
    }
    data = reinterpret_cast<char *>(inside_);
    return true;
}

Array::Array(nb::handle source, const char *array_name, Kind kind) : name(array_name)
{
    PyObject *p = source.ptr();
    if (p == Py_None)
        throw nb::type_error((std::string(name) + " is None: pass an array or a number").c_str());
    if (PyObject_CheckBuffer(p)) {
        acquire(source, kind, false);
        return;
    }
    if (take_numbers(source, kind))
        return;
    const bool sequence = PyList_Check(p) || PyTuple_Check(p);
    const nb::object array = kind == Kind::real && sequence ? numpy("asarray")(source, "float64")
                                                            : numpy("asarray")(source);
    acquire(array, kind, false);
}

Array Array::output(nb::handle target, const char *name, Kind kind, const Shape &wanted)
{
    Array array(name, 0);
    if (!PyObject_CheckBuffer(target.ptr()))
        throw nb::type_error((std::string(name) + " must be a numpy array").c_str());
    array.acquire(target, kind, true);
    if (!(array.shape == wanted))
        throw nb::value_error((std::string(name) + " has shape " + array.shape.text() +
                               ", the result has " + wanted.text())
                                  .c_str());
    return array;
}

Array::Array(Array &&other) noexcept
    : name(other.name), object(std::move(other.object)), type(other.type), data(other.data),
      shape(other.shape), buffer_(std::move(other.buffer_))
{
    std::copy(other.inside_, other.inside_ + 3, inside_);
    std::copy(other.stride, other.stride + max_dims, stride);
    if (!buffer_.held)
        data = reinterpret_cast<char *>(inside_);
}

Py_ssize_t Array::take_channels()
{
    if (shape.n == 0 || shape.dim[shape.n - 1] != 3) {
        std::string text = std::string(name) + " has shape " + shape.text() +
                           ", but its last dimension must hold 3 channels";
        if (shape.n && shape.dim[shape.n - 1] == 4)
            text += std::string(": pass ") + name + "[..., :3] and keep the fourth yourself";
        throw nb::value_error(text.c_str());
    }
    return stride[--shape.n];
}

Array new_array(const Shape &shape, lcor_sample type)
{
    /* looked up once and kept: making an array is most of the cost of a small call */
    static const nb::handle empty = numpy("empty").release();
    static const nb::handle types[] = {
        numpy("dtype")("float32").release(), numpy("dtype")("float64").release(),
        numpy("dtype")("uint8").release(), numpy("dtype")("uint16").release()};
    const nb::object lengths = nb::steal(PyTuple_New(shape.n));
    for (int d = 0; d < shape.n; d++)
        PyTuple_SetItem(lengths.ptr(), d, PyLong_FromSsize_t(shape.dim[d]));
    const nb::object array = empty(lengths, types[type]);
    return Array::output(array, "out", Kind::colour, shape);
}

/* First and last byte of an array; nothing for one without elements. */
static bool bounds(const Array &array, const char *&first, const char *&last)
{
    first = array.data;
    last = array.data + sample_size(array.type);
    for (int d = 0; d < array.shape.n; d++) {
        if (array.shape.dim[d] == 0)
            return false;
        const Py_ssize_t reach = (array.shape.dim[d] - 1) * array.stride[d];
        (reach < 0 ? first : last) += reach;
    }
    return true;
}

void check_overlap(const Array &out, const Array &in, bool same_allowed)
{
    const char *out_first, *out_last, *in_first, *in_last;
    if (!bounds(out, out_first, out_last) || !bounds(in, in_first, in_last) ||
        out_last <= in_first || in_last <= out_first)
        return;
    if (same_allowed && out.data == in.data && out.type == in.type && out.shape == in.shape &&
        std::equal(out.stride, out.stride + out.shape.n, in.stride))
        return;
    if (nb::cast<bool>(numpy("shares_memory")(out.object, in.object)))
        throw nb::value_error((std::string(out.name) + " shares memory with " + in.name +
                               ": pass another array, or a copy of " + in.name)
                                  .c_str());
}

nb::object result(const Array &array)
{
    if (array.shape.n > 0)
        return array.object;
    return array.object[nb::make_tuple()];
}
