// Copyright 2026 The flag_sim Authors
//
// Licensed under the Apache License, Version 2.0 (the "License");
// you may not use this file except in compliance with the License.
// You may obtain a copy of the License at
//
//     http://www.apache.org/licenses/LICENSE-2.0
//
// Unless required by applicable law or agreed to in writing, software
// distributed under the License is distributed on an "AS IS" BASIS,
// WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
// See the License for the specific language governing permissions and
// limitations under the License.

// A scanline renderer as it is usually written, in the manner of the source: double reals,
// coordinates rounded to whole pixels, a Z-buffer, Gouraud along the edges by y, then by x.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace
{
struct Corner
{
  double x, y, z, intensity;
};

Corner between(const Corner & a, const Corner & b, double t)
{
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z),
    a.intensity + t * (b.intensity - a.intensity)};
}
}  // namespace

// points, normals: (n, 3) double; matrix: (3, 4) world to (u z, v z, z); light: direction,
// intensity, ambient; colors: (m, 3) of the triangles; rgb: (height, width, 3) uint8.
extern "C" void draw(
  const double * points, const double * normals, int n, const int * triangles, const double * colors,
  int m, const double * matrix, const double * light, const uint8_t * background, int width,
  int height, uint8_t * rgb)
{
  static std::vector<double> depth;
  static std::vector<Corner> corners;
  depth.assign(size_t(width) * height, std::numeric_limits<double>::infinity());
  for (size_t i = 0; i < depth.size(); i++) {
    std::copy(background, background + 3, rgb + 3 * i);
  }
  corners.resize(n);
  for (int i = 0; i < n; i++) {
    const double * p = points + 3 * i, * q = normals + 3 * i;
    double at[3];
    for (int k = 0; k < 3; k++) {
      const double * row = matrix + 4 * k;
      at[k] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
    }
    double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
    double cosine = (q[0] * light[0] + q[1] * light[1] + q[2] * light[2]) / length;
    corners[i] = {std::round(at[0] / at[2]), std::round(at[1] / at[2]), at[2],
      light[4] + light[3] * std::abs(cosine)};
  }
  for (int t = 0; t < m; t++) {
    Corner a = corners[triangles[3 * t]], b = corners[triangles[3 * t + 1]],
      c = corners[triangles[3 * t + 2]];
    if (a.z <= 0 || b.z <= 0 || c.z <= 0) {continue;}
    if (b.y < a.y) {std::swap(a, b);}
    if (c.y < a.y) {std::swap(a, c);}
    if (c.y < b.y) {std::swap(b, c);}
    int last = int(std::min(c.y, height - 1.0));
    for (int y = int(std::max(a.y, 0.0)); y <= last; y++) {
      Corner p = c.y > a.y ? between(a, c, (y - a.y) / (c.y - a.y)) : a;
      Corner q = y < b.y ? between(a, b, (y - a.y) / (b.y - a.y)) :
        c.y > b.y ? between(b, c, (y - b.y) / (c.y - b.y)) : b;
      if (q.x < p.x) {std::swap(p, q);}
      int end = int(std::min(q.x, width - 1.0));
      for (int x = int(std::max(p.x, 0.0)); x <= end; x++) {
        Corner here = q.x > p.x ? between(p, q, (x - p.x) / (q.x - p.x)) : p;
        size_t i = size_t(y) * width + x;
        if (here.z < depth[i]) {
          depth[i] = here.z;
          for (int k = 0; k < 3; k++) {
            rgb[3 * i + k] = uint8_t(std::min(colors[3 * t + k] * here.intensity, 255.0));
          }
        }
      }
    }
  }
}
