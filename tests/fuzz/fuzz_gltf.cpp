/* SPDX-License-Identifier: MIT */
/* Scene files from memory: reading, converting, committing. Whatever the bytes are, the only way
 * out but success is a cli::Error.
 *
 * tinygltf is compiled in here, rather than linked, so that it is instrumented too. */
#include "gltf.h"
#include "message.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>
#define TINYGLTF_NO_INCLUDE_STB_IMAGE
#define TINYGLTF_NO_INCLUDE_STB_IMAGE_WRITE
#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>

#include <cstring>
#include <random>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define LCOR_LEAKS_COUNTED
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define LCOR_LEAKS_COUNTED
#endif
#ifdef LCOR_LEAKS_COUNTED
#include <sanitizer/lsan_interface.h>
#endif

/* OpenImageIO loses the text of an error for every broken PNG, since libpng jumps over destructors:
 * PNGInput::PngReadCallback. Leaks count everywhere else. */
static cli::Image decode(const uint8_t *bytes, size_t size, const std::string &name)
{
#ifdef LCOR_LEAKS_COUNTED
    const __lsan::ScopedDisabler uncounted;
#endif
    return cli::decode_image(bytes, size, name);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static cli::Threads threads(1);
    cli::set_silent(true);
    cli::SceneOptions options;
    options.need_light = false;
    try {
        const std::string bytes(reinterpret_cast<const char *>(data), size);
        cli::build_scene(cli::parse_gltf(bytes, "input", "", threads, decode), options, "input",
                         threads);
    } catch (const cli::Error &) {
    }
    return 0;
}

#ifdef LCOR_LIBFUZZER

/* Most changes to bytes of a scene leave no JSON. Every other change is one of the document: a
 * value replaced by another one of the document or by a number at a limit, removed, or doubled. */

using Document = nlohmann::json;

extern "C" size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

static void collect(Document &value, std::vector<Document *> &out)
{
    out.push_back(&value);
    if (value.is_structured())
        for (Document &part : value)
            collect(part, out);
}

static void change(Document &document, std::minstd_rand &random)
{
    static const int64_t numbers[] = {-1,    0,     1,     2,       3,          4,
                                      5,     6,     255,   5120,    5121,       5123,
                                      5125,  5126,  9728,  10497,   4096,       4097,
                                      65535, 33071, 33648, 1 << 30, 4294967295, -(1LL << 62)};
    static const double fractions[] = {-0.5, 1e-310, 1e-12, 0.5, 0.999, 1e12, 1e308};
    std::vector<Document *> values;
    collect(document, values);
    Document &value = *values[random() % values.size()];
    const Document other = *values[random() % values.size()];
    switch (random() % 5) {
    case 0: value = other; break;
    case 1: value = fractions[random() % std::size(fractions)]; break;
    case 2: value = numbers[random() % std::size(numbers)]; break;
    case 3:
        if (value.is_structured() && !value.empty())
            value.erase(std::next(value.begin(), static_cast<long>(random() % value.size())));
        break;
    default:
        if (value.is_array())
            value.push_back(other);
        else if (value.is_object())
            value["extras"] = other;
    }
}

/* The JSON of a .gltf or .glb: where it starts and how long it is. */
static std::pair<size_t, size_t> json_part(const uint8_t *data, size_t size)
{
    uint32_t length = 0;
    if (size < 20 || std::memcmp(data, "glTF", 4) != 0)
        return {0, size};
    std::memcpy(&length, data + 12, sizeof length);
    return {20, std::min<size_t>(length, size - 20)};
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size,
                                          unsigned seed);
extern "C" size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size,
                                          unsigned seed)
{
    std::minstd_rand random(seed);
    const auto [start, length] = json_part(data, size);
    Document document = random() % 2 == 0
                            ? Document::parse(data + start, data + start + length, nullptr, false)
                            : Document(Document::value_t::discarded);
    if (document.is_discarded() || document.size() == 0)
        return LLVMFuzzerMutate(data, size, max_size);
    for (unsigned i = 0; i <= random() % 3; i++)
        change(document, random);
    std::string text = document.dump(-1, ' ', false, Document::error_handler_t::replace);
    if (start > 0)
        text.append(3 - (text.size() + 3) % 4, ' ');
    std::vector<uint8_t> out(data, data + start);
    out.insert(out.end(), text.begin(), text.end());
    out.insert(out.end(), data + start + length, data + size);
    if (out.size() > max_size)
        return LLVMFuzzerMutate(data, size, max_size);
    if (start > 0) {
        const uint32_t whole = static_cast<uint32_t>(out.size());
        const uint32_t part = static_cast<uint32_t>(text.size());
        std::memcpy(&out[8], &whole, sizeof whole);
        std::memcpy(&out[12], &part, sizeof part);
    }
    std::memcpy(data, out.data(), out.size());
    return out.size();
}

#endif
