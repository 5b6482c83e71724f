/* SPDX-License-Identifier: MIT */
/* MTL materials: Kd, map_Kd, Ke, map_Ke. */
#include "obj.h"

#include <algorithm>

namespace cli
{

namespace
{

constexpr double brightest = 1e9;

/* "r g b", or one number for all three. */
bool read_colour(const WordLines &line, double high, double *out,
                 std::set<std::string> &unsupported)
{
    if (!line.number(1)) {
        unsupported.insert("colours as spectra or XYZ");
        return false;
    }
    for (size_t c = 0; c < 3; c++)
        out[c] = std::clamp(line.number(1 + c).value_or(c > 0 ? out[c - 1] : 0.0), 0.0, high);
    return true;
}

/* Up to three numbers from word `i` on, the first two of which count; returns the word after. */
size_t read_pair(const WordLines &line, size_t i, std::array<double, 2> &out)
{
    for (size_t k = 0; k < 3 && line.number(i); k++, i++)
        if (k < 2)
            out[k] = *line.number(i);
    return i;
}

ObjTexture read_texture(const WordLines &line, std::set<std::string> &unsupported)
{
    ObjTexture out;
    size_t i = 1;
    while (i < line.size() && line.word(i)[0] == '-') {
        const std::string_view option = line.word(i++);
        if (option == "-o") {
            i = read_pair(line, i, out.offset);
        } else if (option == "-s") {
            i = read_pair(line, i, out.scale);
        } else if (option == "-clamp") {
            out.clamp = line.rest(i).compare(0, 2, "on") == 0;
            i++;
        } else {
            unsupported.insert("texture options other than -o, -s and -clamp");
            std::array<double, 2> ignored{};
            i = option == "-mm" || option == "-t" ? read_pair(line, i, ignored) : i + 1;
        }
    }
    out.file = line.rest(i);
    std::replace(out.file.begin(), out.file.end(), '\\', '/');
    return out;
}

void say_unsupported(const WordLines &line, std::set<std::string> &unsupported)
{
    const std::string_view key = line.word(0);
    const auto above = [&](double limit) {
        for (size_t i = 1; i < line.size(); i++)
            if (line.number(i).value_or(0.0) > limit)
                return true;
        return false;
    };
    if (key == "map_d" || (key == "d" && !above(1.0 - 1e-9)) || (key == "Tr" && above(1e-9)))
        unsupported.insert("transparency (drawn opaque)");
    if (key == "refl" || key == "map_Ks" || ((key == "Ks" || key == "Pm") && above(0.0)))
        unsupported.insert("specular and metallic surfaces (taken as diffuse)");
    for (const char *name : {"bump", "map_bump", "map_Bump", "norm", "disp"})
        if (key == name)
            unsupported.insert("normal and displacement maps");
}

} // namespace

void parse_mtl(std::string_view text, ObjMaterials &materials, std::set<std::string> &unsupported)
{
    ObjMaterial unnamed, *at = &unnamed;
    for (WordLines line(text); line.next();) {
        const std::string_view key = line.word(0);
        if (key == "newmtl") {
            at = &materials[line.rest(1)];
            *at = ObjMaterial();
            at->material.name = line.rest(1);
        } else if (key == "Kd") {
            at->coloured = read_colour(line, 1.0, at->material.colour, unsupported);
        } else if (key == "Ke") {
            read_colour(line, brightest, at->material.emission, unsupported);
        } else if (key == "map_Kd") {
            at->diffuse = read_texture(line, unsupported);
        } else if (key == "map_Ke") {
            at->emitted = read_texture(line, unsupported);
        } else {
            say_unsupported(line, unsupported);
        }
    }
}

} // namespace cli
