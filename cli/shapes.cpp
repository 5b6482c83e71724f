/* SPDX-License-Identifier: MIT */
#include "shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <unordered_map>

namespace cli
{

namespace
{

/* Same meaning as in liblcor, a little stricter: what is kept here is accepted there. */
constexpr double flat_limit = 1e-11;
constexpr double largest_coordinate = 1e15;

struct Pair {
    size_t first, second;         /* triangles */
    size_t first_edge, other_end; /* edge of the first; corner of the second opposite it */
    int skew;                     /* 0: a rectangle .. 1000 */
};

bool has_area(const Triangle &triangle)
{
    const Vec3 u = triangle.corner[1].position - triangle.corner[0].position;
    const Vec3 v = triangle.corner[2].position - triangle.corner[0].position;
    const Vec3 w = v - u;
    const double longest = std::max({dot(u, u), dot(v, v), dot(w, w)});
    return length(cross(u, v)) > flat_limit * longest;
}

bool near(double a, double b, double tolerance) { return std::fabs(a - b) <= tolerance; }

/* Does d continue the plane of textures and colours over a, b, c to the corner a + c - b? */
bool continues(const Vertex &a, const Vertex &b, const Vertex &c, const Vertex &d)
{
    const Vec3 corner = a.position + c.position - b.position;
    double size = 0.0, reach = 0.0;
    for (size_t k = 0; k < 3; k++) {
        size = std::max({size, std::fabs(a.position[k] - c.position[k]),
                         std::fabs(b.position[k] - d.position[k])});
        reach = std::max(reach, std::fabs(d.position[k]));
    }
    /* Files hold 24-bit floats; rotations of them add a few roundings. */
    if (length(corner - d.position) > 1e-6 * size + 5e-7 * reach)
        return false;
    for (size_t k = 0; k < 2; k++)
        if (!near(a.uv[k] + c.uv[k] - b.uv[k], d.uv[k], 1e-4))
            return false;
    for (size_t k = 0; k < 3; k++)
        if (!near(a.colour[k] + c.colour[k] - b.colour[k], d.colour[k], 1e-3))
            return false;
    return true;
}

bool same_look(const Vertex &a, const Vertex &b)
{
    return near(a.uv[0], b.uv[0], 1e-6) && near(a.uv[1], b.uv[1], 1e-6) &&
           length(a.colour - b.colour) <= 1e-6;
}

int skew_of(const Vertex &a, const Vertex &b, const Vertex &c)
{
    const Vec3 u = a.position - b.position, v = c.position - b.position;
    return static_cast<int>(std::lround(1000.0 * std::fabs(dot(u, v)) / (length(u) * length(v))));
}

/* Numbers for places: equal coordinates, equal number. */
class Places
{
  public:
    uint32_t number(const Vec3 &p)
    {
        return numbers_.emplace(p, static_cast<uint32_t>(numbers_.size())).first->second;
    }

  private:
    struct Hash {
        size_t operator()(const Vec3 &p) const
        {
            size_t h = 0;
            for (const double x : p)
                h = h * 0x9e3779b97f4a7c15U + std::hash<double>()(x);
            return h;
        }
    };
    std::unordered_map<Vec3, uint32_t, Hash> numbers_;
};

struct Edge {
    uint32_t from, to;
    size_t triangle, index; /* starts at corner `index` */
};

/* All edges, those between the same two places together. */
std::vector<Edge> sorted_edges(const std::vector<Triangle> &triangles,
                               const std::vector<bool> &good)
{
    Places places;
    std::vector<Edge> edges;
    for (size_t i = 0; i < triangles.size(); i++) {
        if (!good[i])
            continue;
        uint32_t at[3];
        for (size_t k = 0; k < 3; k++)
            at[k] = places.number(triangles[i].corner[k].position);
        for (size_t k = 0; k < 3; k++)
            edges.push_back({at[k], at[(k + 1) % 3], i, k});
    }
    const auto key = [](const Edge &e) { return std::minmax(e.from, e.to); };
    std::stable_sort(edges.begin(), edges.end(), [&](const Edge &a, const Edge &b) {
        return std::pair<uint32_t, uint32_t>(key(a)) < std::pair<uint32_t, uint32_t>(key(b));
    });
    return edges;
}

void consider(const std::vector<Triangle> &triangles, const Edge &e, const Edge &f,
              std::vector<Pair> &pairs)
{
    const Triangle &one = triangles[e.triangle], &two = triangles[f.triangle];
    /* Facing the same way, the shared edge runs in opposite directions. */
    if (one.group != two.group || e.from != f.to || e.triangle == f.triangle)
        return;
    const Vertex &a = one.corner[e.index], &c = one.corner[(e.index + 1) % 3];
    const Vertex &b = one.corner[(e.index + 2) % 3];
    const size_t other = (f.index + 2) % 3;
    if (same_look(a, two.corner[(f.index + 1) % 3]) && same_look(c, two.corner[f.index]) &&
        continues(a, b, c, two.corner[other]))
        pairs.push_back({e.triangle, f.triangle, e.index, other, skew_of(a, b, c)});
}

std::vector<Pair> find_pairs(const std::vector<Triangle> &triangles, const std::vector<bool> &good)
{
    const std::vector<Edge> edges = sorted_edges(triangles, good);
    std::vector<Pair> pairs;
    for (size_t start = 0, end; start < edges.size(); start = end) {
        const Edge &first = edges[start];
        for (end = start + 1; end < edges.size() && std::minmax(edges[end].from, edges[end].to) ==
                                                        std::minmax(first.from, first.to);)
            end++;
        /* Where many triangles meet in one edge there is no telling which belong together. */
        for (size_t i = start; i < end && end - start <= 8; i++)
            for (size_t j = i + 1; j < end; j++)
                consider(triangles, edges[i], edges[j], pairs);
    }
    std::sort(pairs.begin(), pairs.end(), [](const Pair &a, const Pair &b) {
        return std::tie(a.skew, a.first, a.second, a.first_edge) <
               std::tie(b.skew, b.first, b.second, b.first_edge);
    });
    return pairs;
}

/* The parallelogram's corners in order, starting where the first triangle starts. */
Shape join(const std::vector<Triangle> &triangles, const Pair &pair)
{
    const Triangle &one = triangles[pair.first];
    Shape shape;
    shape.quad = true;
    shape.group = one.group;
    size_t n = 0;
    for (size_t k = 0; k < 3; k++) {
        shape.corner[n++] = one.corner[k];
        if (k == pair.first_edge)
            shape.corner[n++] = triangles[pair.second].corner[pair.other_end];
    }
    return shape;
}

} // namespace

std::vector<Shape> make_shapes(const Contents &contents, const std::string &name, size_t *dropped)
{
    const std::vector<Triangle> &triangles = contents.triangles;
    std::vector<bool> good(triangles.size());
    *dropped = 0;
    for (size_t i = 0; i < triangles.size(); i++) {
        for (const Vertex &vertex : triangles[i].corner)
            for (const double x : vertex.position)
                if (!(std::fabs(x) <= largest_coordinate))
                    fail(Exit::input, "scene '%s', %s: a vertex is not finite or too far away",
                         name.c_str(), contents.groups[triangles[i].group].name.c_str());
        good[i] = has_area(triangles[i]);
        *dropped += good[i] ? 0 : 1;
    }
    constexpr size_t none = static_cast<size_t>(-1);
    std::vector<size_t> chosen(triangles.size(), none); /* pair a triangle leads */
    size_t joined = 0;
    const std::vector<Pair> pairs = find_pairs(triangles, good);
    for (size_t i = 0; i < pairs.size(); i++) {
        if (!good[pairs[i].first] || !good[pairs[i].second])
            continue;
        /* Taken: the first one stands for both, the second for nothing. */
        good[pairs[i].first] = good[pairs[i].second] = false;
        chosen[pairs[i].first] = i;
        joined++;
    }
    std::vector<Shape> shapes;
    shapes.reserve(static_cast<size_t>(std::count(good.begin(), good.end(), true)) + joined);
    for (size_t i = 0; i < triangles.size(); i++) {
        if (chosen[i] != none)
            shapes.push_back(join(triangles, pairs[chosen[i]]));
        else if (good[i])
            shapes.push_back(
                {{triangles[i].corner[0], triangles[i].corner[1], triangles[i].corner[2], Vertex{}},
                 false,
                 triangles[i].group});
    }
    return shapes;
}

size_t settle_twins(std::vector<Shape> &shapes)
{
    using Corners = std::array<uint32_t, 4>;
    Places places;
    std::vector<std::pair<Corners, size_t>> order;
    order.reserve(shapes.size());
    for (size_t i = 0; i < shapes.size(); i++) {
        Corners corners{0, 0, 0, std::numeric_limits<uint32_t>::max()};
        for (size_t k = 0; k < (shapes[i].quad ? 4U : 3U); k++)
            corners[k] = places.number(shapes[i].corner[k].position);
        std::sort(corners.begin(), corners.end());
        order.emplace_back(corners, i);
    }
    std::sort(order.begin(), order.end());
    const auto normal = [](const Shape &shape) {
        return cross(shape.corner[1].position - shape.corner[0].position,
                     shape.corner[2].position - shape.corner[0].position);
    };
    std::vector<bool> left_out(shapes.size());
    size_t count = 0;
    for (size_t start = 0, i = 1; i < order.size(); i++) {
        if (order[i].first != order[start].first) {
            start = i;
            continue;
        }
        Shape &front = shapes[order[start].second], &twin = shapes[order[i].second];
        if (dot(normal(front), normal(twin)) < 0.0 && !front.back_to_back) {
            front.back_to_back = twin.back_to_back = true;
        } else {
            left_out[order[i].second] = true;
            count++;
        }
    }
    size_t kept = 0;
    for (size_t i = 0; i < shapes.size(); i++)
        if (!left_out[i])
            shapes[kept++] = shapes[i];
    shapes.resize(kept);
    return count;
}

} // namespace cli
