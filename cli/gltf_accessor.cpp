/* SPDX-License-Identifier: MIT */
/* Numbers out of glTF buffers, every offset checked. */
#include "gltf.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cli
{

namespace
{

template <class T> double load(const unsigned char *at)
{
    T value;
    std::memcpy(&value, at, sizeof value);
    return static_cast<double>(value);
}

double read_component(const unsigned char *at, int type, bool normalised)
{
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return normalised ? std::max(load<int8_t>(at) / 127.0, -1.0) : load<int8_t>(at);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return normalised ? load<uint8_t>(at) / 255.0 : load<uint8_t>(at);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return normalised ? std::max(load<int16_t>(at) / 32767.0, -1.0) : load<int16_t>(at);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return normalised ? load<uint16_t>(at) / 65535.0 : load<uint16_t>(at);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return load<uint32_t>(at);
    default: return load<float>(at);
    }
}

size_t component_size(int type)
{
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT: return 4;
    default: return 0;
    }
}

/* The first of `count` elements of `size` bytes in a buffer view, and the step to the next. */
const unsigned char *locate(const ModelFile &file, int accessor, int view_index, size_t offset,
                            size_t count, size_t size, size_t *step)
{
    const tinygltf::Model &model = *file.model;
    const auto bad = [&](const char *what) {
        fail(Exit::input, "scene '%s', accessor %d: %s", file.name.c_str(), accessor, what);
    };
    if (view_index < 0 || static_cast<size_t>(view_index) >= model.bufferViews.size())
        bad("no such buffer view");
    const tinygltf::BufferView &view = model.bufferViews[static_cast<size_t>(view_index)];
    if (view.buffer < 0 || static_cast<size_t>(view.buffer) >= model.buffers.size())
        bad("its buffer view names no buffer");
    const std::vector<unsigned char> &data = model.buffers[static_cast<size_t>(view.buffer)].data;
    if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset)
        bad("its buffer view lies outside the buffer");
    *step = view.byteStride > 0 ? view.byteStride : size;
    if (count == 0)
        return data.data();
    if (offset > view.byteLength || size > view.byteLength - offset ||
        (count - 1) > (view.byteLength - offset - size) / *step)
        bad("it reaches past the end of its buffer view");
    return data.data() + view.byteOffset + offset;
}

void apply_sparse(const ModelFile &file, int index, const tinygltf::Accessor &accessor,
                  Accessor &out)
{
    const auto &sparse = accessor.sparse;
    const size_t count = sparse.count > 0 ? static_cast<size_t>(sparse.count) : 0;
    const size_t index_size = component_size(sparse.indices.componentType);
    const size_t size = component_size(accessor.componentType);
    if (count > out.count || index_size == 0 || sparse.indices.byteOffset < 0 ||
        sparse.values.byteOffset < 0)
        fail(Exit::input, "scene '%s', accessor %d: broken sparse part", file.name.c_str(), index);
    size_t index_step, step;
    const unsigned char *const indices =
        locate(file, index, sparse.indices.bufferView,
               static_cast<size_t>(sparse.indices.byteOffset), count, index_size, &index_step);
    const unsigned char *const values =
        locate(file, index, sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset),
               count, size * out.components, &step);
    for (size_t i = 0; i < count; i++) {
        const double at =
            read_component(indices + i * index_step, sparse.indices.componentType, false);
        if (!(at >= 0.0 && at < static_cast<double>(out.count)))
            fail(Exit::input, "scene '%s', accessor %d: sparse index out of range",
                 file.name.c_str(), index);
        for (size_t c = 0; c < out.components; c++)
            out.values[static_cast<size_t>(at) * out.components + c] = read_component(
                values + i * step + c * size, accessor.componentType, accessor.normalized);
    }
}

} // namespace

Accessor read_accessor(const ModelFile &file, int index, size_t components)
{
    const tinygltf::Model &model = *file.model;
    if (index < 0 || static_cast<size_t>(index) >= model.accessors.size())
        fail(Exit::input, "scene '%s': no accessor %d", file.name.c_str(), index);
    const tinygltf::Accessor &accessor = model.accessors[static_cast<size_t>(index)];
    const int there = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
    const size_t size = component_size(accessor.componentType);
    if (there < 1 || there > 4 || size == 0 ||
        (components > 0 && components != static_cast<size_t>(there)))
        fail(Exit::input, "scene '%s', accessor %d: not the type its use asks for",
             file.name.c_str(), index);
    if (accessor.count > file.bytes)
        fail(Exit::input, "scene '%s', accessor %d: %zu elements in a file of %llu bytes",
             file.name.c_str(), index, accessor.count, static_cast<unsigned long long>(file.bytes));
    Accessor out;
    out.count = accessor.count;
    out.components = static_cast<size_t>(there);
    out.values.assign(out.count * out.components, 0.0);
    if (accessor.bufferView >= 0) {
        size_t step;
        const unsigned char *const first =
            locate(file, index, accessor.bufferView, accessor.byteOffset, out.count,
                   size * out.components, &step);
        for (size_t i = 0; i < out.count; i++)
            for (size_t c = 0; c < out.components; c++)
                out.values[i * out.components + c] = read_component(
                    first + i * step + c * size, accessor.componentType, accessor.normalized);
    }
    if (accessor.sparse.isSparse)
        apply_sparse(file, index, accessor, out);
    return out;
}

std::vector<uint32_t> read_indices(const ModelFile &file, int index)
{
    const Accessor accessor = read_accessor(file, index, 1);
    std::vector<uint32_t> indices(accessor.count);
    for (size_t i = 0; i < accessor.count; i++) {
        const double value = accessor.values[i];
        if (!(value >= 0.0 && value < 4294967295.0 && value == std::floor(value)))
            fail(Exit::input, "scene '%s', accessor %d: %s is no vertex index", file.name.c_str(),
                 index, number_text(value).c_str());
        indices[i] = static_cast<uint32_t>(value);
    }
    return indices;
}

} // namespace cli
