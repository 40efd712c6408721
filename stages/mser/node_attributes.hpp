#pragma once
/// What can be measured of the nodes of a component tree in one pass over the mesh: size, scalar, place, shape,
/// topology.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "stages/common/surface.hpp"

namespace meshmser {

/// Of a node with all triangles of its descendants.
struct NodeAttributes {
  std::int64_t num_triangles = 0;
  double area = 0;                               ///< the tree's, in coordinate units squared
  double level_length = 0;                       ///< of its border where a triangle outside lies behind it
  double hole_length = 0;                        ///< of its border along the mesh's own rim, inner loops included
  double scalar_min = 0, scalar_max = 0;         ///< over the corners
  double scalar_mean = 0, scalar_deviation = 0;  ///< of the linear scalar, by area
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of its points about the centroid, by area
  Eigen::Vector3d box_min = Eigen::Vector3d::Zero(), box_max = Eigen::Vector3d::Zero();
  Eigen::Vector3d vector_area = Eigen::Vector3d::Zero();  ///< the integral of the normal
  std::int64_t euler = 0;  ///< Euler number: 1 for a disc, 1 less for each hole in it, 2 for a closed sphere
  std::int32_t depth = 0;  ///< how many of the nodes asked for hold it

  /// Unit; zero where normals cancel out.
  Eigen::Vector3d mean_normal() const;
  /// Length of the integral of the normal over area: 1 on a plane, 0 on a closed surface or without area.
  double flatness() const;
};

/// Directions in which a node spreads most, next and least, and its standard deviation along each.
struct PrincipalAxes {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< unit columns, right-handed; the last is a plane's normal
  Eigen::Vector3d deviations = Eigen::Vector3d::Zero();
};

/// Of a covariance. The component of the first two axes that is largest in size is positive.
PrincipalAxes principal_axes(const Eigen::Matrix3d& covariance);

/// Attributes of the nodes `nodes` (ascending) of a tree, in their order.
///
/// `values`: #V, S; `areas`: #F, of triangle_areas. A vertex at which the node pinches counts for `euler` once for each
/// fan of triangles, as its border loops part there: a region of genus 0 has 2 - euler loops. A node without area has
/// the centroid and the mean of its first triangle. Lengths are exact sums, so an unbroken border is exactly 0; the
/// other sums are taken over a node's own triangles by ascending id, then over its children by ascending node, about a
/// place of the node itself, so that nothing is lost far from the origin. Time linear in the mesh and the nodes;
/// triangles in none of the nodes cost nothing but a look. 400 bytes a node.
std::vector<NodeAttributes> attributes_of_nodes(const SurfaceView& surface, const ComponentTree& tree,
                                                std::span<const std::int32_t> nodes, std::span<const double> values,
                                                std::span<const double> areas);

/// The same of every node (#N).
std::vector<NodeAttributes> attributes_of_nodes(const SurfaceView& surface, const ComponentTree& tree,
                                                std::span<const double> values, std::span<const double> areas);

}  // namespace meshmser
