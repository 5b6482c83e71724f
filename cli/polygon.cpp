/* SPDX-License-Identifier: MIT */
/* Polygons into triangles by cutting off ears. */
#include "obj.h"

#include <numeric>

namespace cli
{

namespace
{

using Point = std::array<double, 2>;

/* Twice the area of a, b, c, positive when they turn left. */
double turn(const Point &a, const Point &b, const Point &c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* The polygon in the coordinate plane it is seen largest in, turning left. */
std::vector<Point> flattened(const std::vector<Vec3> &corners)
{
    Vec3 normal{0.0, 0.0, 0.0}; /* Newell's: twice the area in each coordinate plane */
    for (size_t i = 1; i + 1 < corners.size(); i++)
        normal = normal + cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
    size_t axis = 0;
    for (size_t k = 1; k < 3; k++)
        if (std::fabs(normal[k]) > std::fabs(normal[axis]))
            axis = k;
    size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    if (normal[axis] < 0.0)
        std::swap(u, v);
    std::vector<Point> points;
    for (const Vec3 &corner : corners)
        points.push_back({corner[u], corner[v]});
    return points;
}

/* Does corner `i` of those left stick out, with no other corner in its triangle? */
bool is_ear(const std::vector<Point> &points, const std::vector<size_t> &left, size_t i)
{
    const size_t n = left.size();
    const Point &a = points[left[(i + n - 1) % n]], &b = points[left[i]];
    const Point &c = points[left[(i + 1) % n]];
    if (!(turn(a, b, c) > 0.0))
        return false;
    for (const size_t other : left) {
        const Point &p = points[other];
        const bool corner = p == a || p == b || p == c; /* bridges to holes pass a corner twice */
        if (!corner && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0)
            return false;
    }
    return true;
}

} // namespace

std::vector<std::array<size_t, 3>> triangulate(const std::vector<Vec3> &corners)
{
    const std::vector<Point> points = flattened(corners);
    std::vector<size_t> left(corners.size());
    std::iota(left.begin(), left.end(), size_t(0));
    std::vector<std::array<size_t, 3>> triangles;
    while (left.size() >= 3) {
        /* The first corner comes last, so that a convex polygon becomes a fan around it. */
        const size_t n = left.size();
        size_t ear = 1;
        while (ear < n && !is_ear(points, left, ear % n))
            ear++;
        ear = ear < n || is_ear(points, left, 0) ? ear % n : 1;
        triangles.push_back({left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]});
        left.erase(left.begin() + static_cast<long>(ear));
    }
    return triangles;
}

} // namespace cli
