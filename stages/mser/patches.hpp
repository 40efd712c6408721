#pragma once
/// Edge-connected patches of triangles that bear the same number (definitions 9).

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// Patches are numbered from 1 by decreasing area, then smallest triangle id; 0 is no patch.
struct Patches {
  std::vector<std::int32_t> patch_of_triangle;  ///< #F
  std::vector<std::int32_t> number_of_patch;    ///< #P + 1: what its triangles bear; [0] is 0
  std::vector<std::int32_t> first_of_patch;     ///< #P + 1: smallest triangle; [0] is -1
  std::vector<double> area_of_patch;            ///< #P + 1: in the unit of `areas`; [0] is 0

  std::size_t num_patches() const { return number_of_patch.size() - 1; }
};

/// What is split into patches, and what is known of it.
struct SplitOptions {
  bool background = false;     ///< the triangles of number 0 too
  bool whole_numbers = false;  ///< the triangles of each number from 1 on are one patch, and nobody need look
};

/// Splits the triangles of each number but 0 into edge-connected patches. `twins`: 3 #F twin half-edges, -1 at rims;
/// `number_of_triangle`: #F, >= 0; `areas`: #F, finite, >= 0. Areas are summed exactly, so that the order depends on
/// nothing else. O(F), and sorting the patches.
/// Digne et al. 2010, section 3.2. Two passes with a union-find whose roots are the smallest triangles, after Rosenfeld
/// and Pfaltz, 1966.
Patches split_patches(std::span<const std::int32_t> twins, std::span<const std::int32_t> number_of_triangle,
                      std::span<const double> areas, const Execution& execution = {}, SplitOptions options = {});

/// Takes away the patches that cover the whole of their mesh component (edge-connected, without what is cut out): such
/// a patch is background. The others keep their order. O(F).
void drop_whole_components(std::span<const std::int32_t> twins, Patches& patches);

}  // namespace meshmser
