/// The quadric fit beside CGAL's jet fitting (Cazals and Pouget 2005), on the same neighbours.
#include <CGAL/Monge_via_jet_fitting.h>
#include <CGAL/Simple_cartesian.h>
#include <gtest/gtest.h>

#include <cmath>

#include "stages/curvature/quadric.hpp"
#include "tests/support/shapes.hpp"

namespace meshmser {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Jet = CGAL::Monge_via_jet_fitting<Kernel>;

struct Pair {
  double k1, k2;
};

/// Principal curvatures by a jet of degree 2, positive on a sphere seen from outside.
Pair jet_of(const shapes::Sample& s, std::size_t own, double radius) {
  std::vector<Kernel::Point_3> near;
  const auto point = [](const Eigen::Vector3d& p) { return Kernel::Point_3(p.x(), p.y(), p.z()); };
  near.push_back(point(s.points[own]));  // the first is where the curvatures are wanted
  for (std::size_t i = 0; i < s.points.size(); ++i)
    if (i != own && (s.points[i] - s.points[own]).norm() <= radius) near.push_back(point(s.points[i]));
  Jet jet;
  Jet::Monge_form form = jet(near.begin(), near.end(), 2, 2);
  const Eigen::Vector3d& n = s.normals[own];
  form.comply_wrt_given_normal(Kernel::Vector_3(n.x(), n.y(), n.z()));
  return {-form.principal_curvatures(1), -form.principal_curvatures(0)};
}

struct Error {
  double sum = 0, count = 0;
  void add(double difference) { sum += difference * difference, count += 1; }
  double rms() const { return std::sqrt(sum / count); }
};

// Ours fits in the frame of a given normal, CGAL's in that of the neighbours' own plane: on smooth shapes the
// difference is small against either's error, and ours is no worse against the truth.
TEST(Quadric, IsAsGoodAsJetFitting) {
  const double h = 0.03, radius = 4 * h;
  for (const double noise : {0.0, 0.02}) {
    SCOPED_TRACE(testing::Message() << "noise " << noise << " h");
    auto s = shapes::torus(1, 0.4, h);
    std::vector<Pair> truth;
    for (std::size_t i = 0; i < s.points.size(); ++i) truth.push_back({1 / 0.4, 2 * s.mean_curvature[i] - 1 / 0.4});
    shapes::add_noise(s, noise * h, 7);
    const PrincipalCurvatures ours = fit_quadrics(s.points, s.normals, radius);
    Error apart, our_error, jet_error;
    for (std::size_t i = 0; i < s.points.size(); i += 37) {
      const Pair jet = jet_of(s, i, radius);
      apart.add(ours.k1[i] - jet.k1), apart.add(ours.k2[i] - jet.k2);
      our_error.add(ours.k1[i] - truth[i].k1), our_error.add(ours.k2[i] - truth[i].k2);
      jet_error.add(jet.k1 - truth[i].k1), jet_error.add(jet.k2 - truth[i].k2);
    }
    EXPECT_GT(apart.count, 500);
    EXPECT_LT(apart.rms(), 0.5 * jet_error.rms());
    EXPECT_LT(our_error.rms(), 1.1 * jet_error.rms());
    EXPECT_LT(jet_error.rms(), 0.2);
  }
}

}  // namespace
}  // namespace meshmser
