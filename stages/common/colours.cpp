#include "stages/common/colours.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace meshmser {
namespace {

// Light enough for dark border lines; spread over hue at two lightnesses so that neighbours differ in grey, too.
constexpr std::array<Colour, 20> kPalette = {{{102, 166, 214}, {240, 150, 70},  {110, 190, 110}, {222, 110, 105},
                                              {170, 140, 205}, {176, 130, 108}, {232, 150, 198}, {205, 200, 95},
                                              {85, 195, 200},  {120, 130, 190}, {172, 204, 235}, {255, 200, 140},
                                              {170, 224, 155}, {255, 172, 168}, {206, 188, 226}, {206, 172, 160},
                                              {250, 204, 222}, {232, 230, 160}, {168, 224, 230}, {140, 160, 90}}};

// ColorBrewer RdBu reversed and YlOrRd (C. Brewer), colour-blind safe, evenly spaced.
constexpr std::array<Colour, 9> kDiverging = {{{33, 102, 172},
                                               {67, 147, 195},
                                               {146, 197, 222},
                                               {209, 229, 240},
                                               {247, 247, 247},
                                               {253, 219, 199},
                                               {244, 165, 130},
                                               {214, 96, 77},
                                               {178, 24, 43}}};
constexpr std::array<Colour, 9> kSequential = {{{255, 255, 221},
                                                {255, 237, 160},
                                                {254, 217, 118},
                                                {254, 178, 76},
                                                {253, 141, 60},
                                                {252, 78, 42},
                                                {227, 26, 28},
                                                {189, 0, 38},
                                                {128, 0, 38}}};

Colour interpolate(const std::array<Colour, 9>& stops, double t) {
  const double at = std::clamp(t, 0.0, 1.0) * (stops.size() - 1);
  const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(at), stops.size() - 2);
  const double f = at - static_cast<double>(i);
  Colour colour;
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] = static_cast<std::uint8_t>(std::lround(stops[i][c] * (1 - f) + stops[i + 1][c] * f));
  return colour;
}

/// Pairs of different labels, both above 0, on either side of an edge: each pair both ways, sorted.
std::vector<std::pair<std::int32_t, std::int32_t>> neighbouring_labels(
    const TriangleMesh& mesh, std::span<const std::int32_t> label_of_triangle) {
  // Only triangles with a vertex that bears two labels can lie at such an edge.
  std::vector<std::int32_t> label_of_vertex(mesh.num_vertices(), -1);
  std::vector<bool> mixed(mesh.num_vertices(), false);
  for (std::size_t t = 0; t < mesh.num_triangles(); ++t)
    for (std::int32_t v : mesh.triangles[t]) {
      std::int32_t& label = label_of_vertex[static_cast<std::size_t>(v)];
      if (label == -1) label = label_of_triangle[t];
      if (label != label_of_triangle[t]) mixed[static_cast<std::size_t>(v)] = true;
    }
  struct Side {
    std::int32_t a, b, label;
    auto operator<=>(const Side&) const = default;
  };
  std::vector<Side> sides;
  for (std::size_t t = 0; t < mesh.num_triangles(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      if (mixed[static_cast<std::size_t>(a)] && mixed[static_cast<std::size_t>(b)])
        sides.push_back({std::min(a, b), std::max(a, b), label_of_triangle[t]});
    }
  std::sort(sides.begin(), sides.end());
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  for (std::size_t i = 1; i < sides.size(); ++i) {
    const Side &one = sides[i - 1], &two = sides[i];
    if (one.a != two.a || one.b != two.b || one.label == two.label || one.label <= 0 || two.label <= 0) continue;
    pairs.emplace_back(one.label, two.label);
    pairs.emplace_back(two.label, one.label);
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace

std::vector<Colour> label_colours(const TriangleMesh& mesh, std::span<const std::int32_t> label_of_triangle) {
  std::int32_t num_labels = 0;
  for (std::int32_t label : label_of_triangle) num_labels = std::max(num_labels, label);
  const auto pairs = neighbouring_labels(mesh, label_of_triangle);
  std::vector<std::size_t> choice(static_cast<std::size_t>(num_labels) + 1, kPalette.size());
  std::array<std::int64_t, kPalette.size()> uses{};
  auto pair = pairs.begin();
  for (std::int32_t label = 1; label <= num_labels; ++label) {
    std::array<bool, kPalette.size()> taken{};
    for (; pair != pairs.end() && pair->first == label; ++pair)
      if (pair->second < label) taken[choice[static_cast<std::size_t>(pair->second)]] = true;
    std::size_t best = kPalette.size();
    const bool all_taken = std::all_of(taken.begin(), taken.end(), [](bool is_taken) { return is_taken; });
    for (std::size_t c = 0; c < kPalette.size(); ++c)
      if ((all_taken || !taken[c]) && (best == kPalette.size() || uses[c] < uses[best])) best = c;
    choice[static_cast<std::size_t>(label)] = best;
    ++uses[best];
  }
  std::vector<Colour> colours(choice.size(), kBackgroundLabelColour);
  for (std::size_t label = 1; label < colours.size(); ++label) colours[label] = kPalette[choice[label]];
  return colours;
}

ColourMap ColourMap::of_values(std::span<const double> values, double clip) {
  std::vector<double> finite;
  finite.reserve(values.size());
  for (double value : values)
    if (std::isfinite(value)) finite.push_back(value);
  if (finite.empty()) return {};
  auto quantile = [&](double share) {
    auto at = finite.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(finite.size() - 1));
    std::nth_element(finite.begin(), at, finite.end());
    return *at;
  };
  ColourMap map{quantile(clip), quantile(1 - clip)};
  if (map.low < 0 && map.high > 0) {
    map.high = std::max(map.high, -map.low);
    map.low = -map.high;
  } else if (map.low == map.high) {
    map.high = map.low + 1;
  }
  return map;
}

Colour ColourMap::operator()(double value) const {
  if (std::isnan(value)) return kUndefinedColour;
  const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
  if (low < 0 && high > 0) return interpolate(kDiverging, t);
  if (high <= 0) return interpolate(kDiverging, t / 2);
  return interpolate(kSequential, t);
}

}  // namespace meshmser
