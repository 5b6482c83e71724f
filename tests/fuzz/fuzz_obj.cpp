/* SPDX-License-Identifier: MIT */
/* Wavefront OBJ and MTL from memory: reading, cutting polygons, committing. The same bytes are read
 * as both. Whatever they are, the only way out but success is a cli::Error. */
#include "message.h"
#include "obj.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static cli::Threads threads(1);
    cli::set_silent(true);
    cli::SceneOptions options;
    options.need_light = false;
    const std::string_view text(reinterpret_cast<const char *>(data), size);
    try {
        cli::ObjMaterials materials;
        std::set<std::string> unsupported;
        cli::parse_mtl(text, materials, unsupported);
        cli::build_scene(cli::parse_obj(text, "input", "", threads), options, "input", threads);
    } catch (const cli::Error &) {
    }
    return 0;
}
