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

/* libpng's errors jump over OpenImageIO's destructors, which loses some bytes for every broken PNG.
 */
extern "C" const char *__asan_default_options();
extern "C" const char *__asan_default_options() { return "detect_leaks=0"; }

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static cli::Threads threads(1);
    cli::set_silent(true);
    cli::SceneOptions options;
    options.need_light = false;
    try {
        const std::string bytes(reinterpret_cast<const char *>(data), size);
        cli::build_scene(cli::parse_gltf(bytes, "input", "", threads), options, "input", threads);
    } catch (const cli::Error &) {
    }
    return 0;
}
