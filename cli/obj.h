/* SPDX-License-Identifier: MIT */
/* Reading Wavefront OBJ with its MTL: polygons (obj), materials (mtl), lines of text (word_lines).
 */
#ifndef LCOR_CLI_OBJ_H
#define LCOR_CLI_OBJ_H

#include "contents.h"

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cli
{

/* Text as lines of words: a backslash at the end continues a line, a word that starts with '#'
 * ends it. Lines without words and a byte order mark are passed over. */
class WordLines
{
  public:
    explicit WordLines(std::string_view text) : left_(text)
    {
        constexpr std::string_view mark = "\xef\xbb\xbf";
        if (left_.substr(0, mark.size()) == mark)
            left_.remove_prefix(mark.size());
    }
    bool next(); /* false at the end of the text */
    size_t line() const { return line_; }
    size_t size() const { return words_.size(); }
    std::string_view word(size_t i) const { return words_[i]; }
    /* From word `i` to the end of the line, "" beyond it: names may hold spaces. */
    std::string rest(size_t i) const;
    /* Word `i` as a finite number, if it is one. */
    std::optional<double> number(size_t i) const;

  private:
    void fetch();

    std::string_view left_;
    std::string text_;
    std::vector<std::string_view> words_; /* of text_ */
    size_t line_ = 0, height_ = 1;        /* height_: lines of the file that text_ was put from */
};

struct ObjTexture {
    std::string file; /* as written, empty: none */
    bool clamp = false;
    std::array<double, 2> offset{0.0, 0.0}, scale{1.0, 1.0}; /* of the texture coordinates */
};

struct ObjMaterial {
    Material material;
    bool coloured = false; /* Kd was given */
    ObjTexture diffuse, emitted;
};

using ObjMaterials = std::map<std::string, ObjMaterial>;

/* Adds the materials of an MTL file; features without support get their names into `unsupported`.
 */
void parse_mtl(std::string_view text, ObjMaterials &materials, std::set<std::string> &unsupported);

/* An OBJ from memory; what it names is looked for in `folder`, nowhere if empty. */
Contents parse_obj(std::string_view text, const std::string &name, const std::string &folder,
                   Threads &threads);

/* A simple polygon cut into triangles of its corners, which turn the way it does. Corners may lie a
 * little out of a plane; of a polygon that crosses itself every corner is used. */
std::vector<std::array<size_t, 3>> triangulate(const std::vector<Vec3> &corners);

} // namespace cli

#endif
