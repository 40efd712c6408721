#pragma once
/// Growth of label patches over what is not labelled, and the end of patches that are too small (definitions 9).
/// Labels are #F numbers >= 0, 0 for background. `twins`: 3 #F twin half-edges, -1 at rims, after cut_out_triangles.

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"
#include "stages/common/surface.hpp"

namespace meshmser {

/// Lets every patch of equal label (background included) whose area is below `min_area` join the neighbouring patch
/// with which it has the longest common border; ties to that of the smaller triangle id. The smallest patch goes first;
/// what it joins counts with its area from then on. A patch without neighbours stays. `areas`: #F. `whole_labels`: each
/// label but background is known to be one patch, as floods leave those of patches; one result either way, sooner.
/// O(F), and sorting the patches and the border edges of the small ones.
std::vector<std::int32_t> absorb_small_patches(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                               std::span<const double> areas, double min_area,
                                               const Execution& execution = {}, bool whole_labels = false);

/// Floods unlabelled triangles from labelled ones across edges of least strength first: a watershed whose borders run
/// along the edges where the strength is greatest. `strength`: #V, >= 0; an edge is as strong as the weaker of its
/// ends. `excluded` (#F, or empty) are never labelled. Strength is told apart in 4,096 steps, as many to each doubling
/// of 1 + strength / its median; within a step first met is first served, edges of the seeds by ascending id. O(F).
/// Source: Meyer, Topographic distance and watershed lines, 1994 (flooding with an ordered queue); Cousty, Bertrand,
/// Najman, Couprie, Watershed cuts, 2009 (on edges).
std::vector<std::int32_t> flood_by_strength(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                            std::span<const double> strength,
                                            std::span<const std::uint8_t> excluded = {},
                                            const Execution& execution = {});

/// The same for facets, in the order of curvature x `width` + |turn|: an edge's curvature is that of the weaker of its
/// ends (`curvature`: #V, >= 0, or empty for 0), the turn is the length of the difference between the triangle's unit
/// normal and that of the label where the flood began, which slowly follows the surface on the way (by 3 % a triangle).
/// So a label does not leak round the end of a crest that fades, where ridges meet valleys, and borders run to the very
/// corners. `normals`: #V unit normals, smoother than the triangles' own. `width`: in coordinate units, how far a
/// crest's curvature reaches; 40 h is good.
std::vector<std::int32_t> flood_facets(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                       std::span<const double> curvature, std::span<const Eigen::Vector3d> normals,
                                       double width, std::span<const std::uint8_t> excluded = {});

/// The same in the order of |value - mean value of the label's triangles before the flood|, `values`: #F.
/// Source: Adams and Bischof, Seeded region growing, 1994. Deviation: the means stay those of the seeds.
std::vector<std::int32_t> flood_by_likeness(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                            std::span<const double> values, std::span<const double> areas,
                                            std::span<const std::uint8_t> excluded = {});

/// The mean over each triangle's corners of a value at the vertices (#F).
std::vector<double> triangle_means(const SurfaceView& surface, std::span<const double> values,
                                   const Execution& execution = {});

}  // namespace meshmser
