#pragma once
/// Four doubles at a time, with the same bytes on every machine: the number of lanes is fixed, sums go lane by lane in
/// a fixed order, and no fused multiply-add is used. Processors with AVX2 run the same arithmetic on wider registers.

#include <cstdint>

namespace meshmser {

inline constexpr std::int64_t kLanes = 4;
typedef double Lanes __attribute__((vector_size(32)));
typedef std::int64_t LaneMask __attribute__((vector_size(32)));

}  // namespace meshmser

/// Marks a function to be compiled for plain x86-64 and for AVX2, chosen when the program is loaded. Sanitizers cannot
/// run the chooser, so they get the plain form, which gives the same bytes.
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define MESHMSER_SIMD __attribute__((target_clones("default", "avx2")))
#else
#define MESHMSER_SIMD
#endif
