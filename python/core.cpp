/// The compiled part of the Python module: trees, selections, labels and borders on NumPy arrays.

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

#include "pipeline/execution/error.hpp"
#include "python/arrays.hpp"
#include "python/interruptible.hpp"
#include "python/run.hpp"
#include "stages/borders/borders.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/mser/border_contrast.hpp"
#include "stages/mser/describe_regions.hpp"
#include "stages/mser/grow.hpp"
#include "stages/mser/label_triangles.hpp"
#include "stages/mser/segment.hpp"
#include "stages/mser/select_mser.hpp"
#include "stages/mser/stability.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/edit_tree.hpp"
#include "stages/tree/levels.hpp"
#include "stages/tree/tree_of_shapes.hpp"

namespace meshmser::python {
namespace {

/// A mesh whose arrays are the caller's, with what trees and borders need of it.
struct Surface {
  Array<double> positions;
  Array<std::int32_t> triangles;
  std::vector<std::uint8_t> excluded;  ///< #F, or empty for none
  std::vector<std::int32_t> twins;
  std::vector<double> areas;

  SurfaceView view() const {
    return {rows_of<Eigen::Vector3d>(positions, "positions"),
            rows_of<std::array<std::int32_t, 3>>(triangles, "triangles"), twins};
  }
  std::size_t num_vertices() const { return static_cast<std::size_t>(positions.shape(0)); }
  std::size_t num_triangles() const { return static_cast<std::size_t>(triangles.shape(0)); }
};

void expect_size(const char* name, std::size_t is, std::size_t expected, const char* of) {
  if (is != expected)
    throw py::value_error(std::string(name) + " has " + std::to_string(is) + " entries; the mesh has " +
                          std::to_string(expected) + " " + of);
}

std::unique_ptr<Surface> make_surface(Array<double> positions, const py::object& triangles,
                                      const std::optional<Array<bool>>& exclude, int threads) {
  auto surface = std::make_unique<Surface>();
  surface->positions = std::move(positions);
  surface->triangles = whole_numbers(triangles, "triangles");
  const SurfaceView view = surface->view();
  if (exclude) {
    const auto flags = values_of(*exclude, "exclude");
    expect_size("exclude", flags.size(), surface->num_triangles(), "triangles");
    surface->excluded.assign(flags.begin(), flags.end());
  }
  interruptible(threads, [&](const Execution& execution) {
    surface->twins = twin_half_edges(view.triangles, view.positions.size(), execution);
    if (const auto defects = find_edge_defects(view.triangles, view.positions.size()); !defects.empty())
      throw StageError("the edge of vertices " + std::to_string(defects[0].smaller_vertex) + " and " +
                       std::to_string(defects[0].greater_vertex) + " has " +
                       std::to_string(defects[0].num_forward + defects[0].num_backward) +
                       " triangles; two at most, in opposite directions, make a surface");
    if (!surface->excluded.empty()) cut_out_triangles(surface->twins, surface->excluded);
    surface->areas = triangle_areas(view.positions, view.triangles, execution);
  });
  return surface;
}

Polarity polarity_of(const std::string& name) {
  if (name == "upper") return Polarity::kUpper;
  if (name == "lower") return Polarity::kLower;
  throw py::value_error("polarity: expected upper or lower, got " + name + "; for shapes call build_tree_of_shapes");
}

std::vector<double> levels_of(const py::object& given, std::span<const double> values, std::pair<double, double> range,
                              Polarity polarity) {
  LevelParameters parameters;
  const py::array array = py::array::ensure(given);
  const char kind = array ? array.dtype().kind() : '?';
  if (!array || array.ndim() > 1 || (array.ndim() == 0 && kind != 'i' && kind != 'u'))
    throw py::value_error("levels: expected a whole number, or the levels in an array of one dimension");
  if (array.ndim() == 1) {
    const Array<double> list = Array<double>::ensure(array);
    if (!list) throw py::value_error("levels: expected numbers");
    const auto levels = values_of(list, "levels");
    parameters.rule = LevelRule::kList;
    parameters.list.assign(levels.begin(), levels.end());
  } else {
    constexpr std::int32_t kMost = 1000000;
    const py::int_ count(given);
    if (count < py::int_(2) || count > py::int_(kMost))
      throw py::value_error("levels: expected 2 to " + std::to_string(kMost));
    parameters.count = count.cast<std::int32_t>();
    std::tie(parameters.low_quantile, parameters.high_quantile) = range;
    if (!(range.first >= 0 && range.first < range.second && range.second <= 1))
      throw py::value_error("range: expected two quantiles between 0 and 1, the smaller first");
  }
  return make_levels(values, {}, parameters, polarity == Polarity::kLower);
}

/// The values of the vertices that are not excluded, NaN elsewhere: levels are laid over these, as the stage tree does.
std::vector<double> values_that_count(const Surface& surface, const Array<double>& scalar) {
  const auto given = values_of(scalar, "values");
  expect_size("values", given.size(), surface.num_vertices(), "vertices");
  const SurfaceView view = surface.view();
  std::vector<double> values(given.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t t = 0; t < view.triangles.size(); ++t)
    if (surface.excluded.empty() || surface.excluded[t] == 0)
      for (const std::int32_t v : view.triangles[t]) {
        values[static_cast<std::size_t>(v)] = given[static_cast<std::size_t>(v)];
        if (!std::isfinite(given[static_cast<std::size_t>(v)]))
          throw StageError("the value of vertex " + std::to_string(v) +
                           " is not finite; exclude its triangles, or mend it");
      }
  return values;
}

std::unique_ptr<ComponentTree> build_tree(const Surface& surface, const Array<double>& scalar, const py::object& levels,
                                          std::pair<double, double> range, const std::string& polarity_name,
                                          int threads) {
  const Polarity polarity = polarity_of(polarity_name);
  const std::vector<double> values = values_that_count(surface, scalar);
  const SurfaceView view = surface.view();
  std::vector<double> heights = levels_of(levels, values, range, polarity);
  return interruptible(threads, [&](const Execution& execution) {
    const auto of_vertex = levels_of_vertices(values, heights, polarity == Polarity::kLower ? -1 : 1, execution);
    auto tree = std::make_unique<ComponentTree>(build_component_tree(
        surface.twins, surface.areas, levels_of_triangles(view.triangles, of_vertex, surface.excluded, execution),
        static_cast<std::int32_t>(heights.size()), execution));
    tree->polarity = polarity;
    tree->levels = std::move(heights);
    return tree;
  });
}

std::unique_ptr<ComponentTree> build_shapes(const Surface& surface, const Array<double>& scalar,
                                            const py::object& levels, std::pair<double, double> range,
                                            std::optional<std::int32_t> root, int threads) {
  const std::vector<double> values = values_that_count(surface, scalar);
  if (root && (*root < 0 || static_cast<std::size_t>(*root) >= surface.num_vertices()))
    throw py::value_error("root: expected a vertex, from 0 to " + std::to_string(surface.num_vertices()) +
                          " (excluded)");
  const SurfaceView view = surface.view();
  const std::vector<double> heights = levels_of(levels, values, range, Polarity::kUpper);
  return interruptible(threads, [&](const Execution& execution) {
    return std::make_unique<ComponentTree>(
        build_tree_of_shapes(view, surface.areas, levels_of_vertices(values, heights, 1, execution), heights,
                             surface.excluded, root.value_or(-1), execution));
  });
}

Against against_of(const std::string& name) {
  if (name == "children") return Against::kChildren;
  if (name == "main_child") return Against::kMainChild;
  throw py::value_error("against: expected children or main_child, got " + name);
}

py::array select(const Surface& surface, const ComponentTree& tree, std::int32_t delta, const std::string& against) {
  const SelectMserParameters parameters{delta, against_of(against)};
  expect_size("the tree", tree.node_of_triangle.size(), surface.num_triangles(), "triangles");
  return to_array(interruptible(0, [&](const Execution&) {
    return select_mser(tree, parameters, open_roots(tree, surface.twins, surface.excluded));
  }));
}

std::vector<std::int32_t> checked_nodes(const ComponentTree& tree, const py::object& listed) {
  const Array<std::int32_t> array = whole_numbers(listed, "nodes");
  const auto given = values_of(array, "nodes");
  std::vector<std::int32_t> nodes(given.begin(), given.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  if (!nodes.empty() && (nodes.front() < 0 || static_cast<std::size_t>(nodes.back()) >= tree.num_nodes()))
    throw py::value_error("nodes: expected whole numbers from 0 to " + std::to_string(tree.num_nodes()) +
                          " (excluded), the tree's nodes");
  return nodes;
}

/// Selected nodes of trees, numbered, and each triangle's region.
struct Regions {
  std::vector<ComponentTree> trees;
  std::vector<SelectedNode> regions;
  std::vector<std::int32_t> label_of_triangle;
};

std::unique_ptr<Regions> label(const std::vector<const ComponentTree*>& trees, const std::vector<py::object>& nodes) {
  if (trees.size() != nodes.size()) throw py::value_error("expected one array of nodes for each tree");
  if (trees.empty()) throw py::value_error("expected at least one tree");
  auto result = std::make_unique<Regions>();
  std::vector<std::vector<std::int32_t>> selected;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    if (trees[i]->node_of_triangle.size() != trees[0]->node_of_triangle.size())
      throw py::value_error("the trees are not of the same mesh");
    selected.push_back(checked_nodes(*trees[i], nodes[i]));
  }
  interruptible(0, [&](const Execution&) {
    for (const ComponentTree* tree : trees) result->trees.push_back(*tree);
    result->regions = order_regions(result->trees, selected);
    result->label_of_triangle = label_triangles(result->trees, result->regions);
  });
  return result;
}

/// Each field of a list of records as an array over the records' own memory.
template <class Record>
py::dict columns_of(std::vector<Record> given) {
  auto kept = std::make_unique<std::vector<Record>>(std::move(given));
  const std::vector<Record>& records = *kept;
  const py::capsule owner(kept.release(), [](void* memory) { delete static_cast<std::vector<Record>*>(memory); });
  const Record none;
  const Record& first = records.empty() ? none : records.front();
  py::dict columns;
  Record::visit(first, [&]<class Field>(const char* name, const Field& field) {
    constexpr auto kStride = static_cast<py::ssize_t>(sizeof(Record));
    const auto count = static_cast<py::ssize_t>(records.size());
    if constexpr (std::is_same_v<Field, Polarity>) {
      py::list names;
      for (const Record& record : records) names.append(name_of(record.polarity));
      columns[name] = names;
    } else if constexpr (std::is_enum_v<Field>) {
      columns[name] = py::array(py::dtype::of<std::underlying_type_t<Field>>(), {count}, {kStride}, &field, owner);
    } else if constexpr (std::is_arithmetic_v<Field>) {
      columns[name] = py::array(py::dtype::of<Field>(), {count}, {kStride}, &field, owner);
    } else if constexpr (std::is_same_v<Field, Eigen::Vector3d>) {
      columns[name] = py::array(py::dtype::of<double>(), {count, py::ssize_t{3}},
                                {kStride, static_cast<py::ssize_t>(sizeof(double))}, field.data(), owner);
    }
  });
  return columns;
}

py::dict attributes(const Surface& surface, const Regions& regions, const Array<double>& scalar, std::int32_t delta,
                    std::optional<double> band) {
  const auto values = values_of(scalar, "values");
  expect_size("values", values.size(), surface.num_vertices(), "vertices");
  expect_size("labels", regions.label_of_triangle.size(), surface.num_triangles(), "triangles");
  if (band && !(*band > 0)) throw py::value_error("band: expected a length greater than 0");
  const SurfaceView view = surface.view();
  py::dict columns = columns_of(interruptible(0, [&](const Execution& execution) {
    std::vector<TreeSelection> selections(regions.trees.size());
    for (std::size_t i = 0; i < regions.trees.size(); ++i) {
      selections[i].changes = change_of_nodes(regions.trees[i], delta);
      selections[i].maxima = find_maxima(regions.trees[i]);
      for (const SelectedNode& region : regions.regions)
        if (region.tree == static_cast<std::int32_t>(i)) selections[i].selected.push_back(region.node);
      std::sort(selections[i].selected.begin(), selections[i].selected.end());
      execution.check();
    }
    std::vector<Region> described =
        describe_regions(view, regions.trees, selections, regions.regions, values, surface.areas);
    if (!band) return described;
    const std::vector<double> means = triangle_means(view, values, execution);
    for (std::size_t i = 0; i < selections.size(); ++i) {
      const std::vector<std::int32_t>& nodes = selections[i].selected;
      const Contrasts contrasts{
          nodes, border_contrasts(view, regions.trees[i], nodes, means, surface.areas, *band, execution)};
      for (std::size_t r = 0; r < described.size(); ++r)
        if (regions.regions[r].tree == static_cast<std::int32_t>(i))
          described[r].contrast = contrasts.of(regions.regions[r].node);
    }
    return described;
  }));
  if (!band) columns.attr("pop")("contrast");
  return columns;
}

std::unique_ptr<BorderLoops> region_borders(const Surface& surface, const Regions& regions, int threads) {
  expect_size("labels", regions.label_of_triangle.size(), surface.num_triangles(), "triangles");
  const SurfaceView view = surface.view();
  return interruptible(threads, [&](const Execution& execution) {
    auto borders = std::make_unique<BorderLoops>();
    borders->first_edge_of_loop.push_back(0);
    for (std::size_t i = 0; i < regions.trees.size(); ++i)
      *borders = merge_borders(
          *borders, extract_borders(view, regions.trees[i],
                                    number_of_nodes(regions.trees[i], regions.regions, static_cast<std::int32_t>(i)),
                                    regions.label_of_triangle, execution));
    return borders;
  });
}

std::unique_ptr<BorderLoops> label_borders(const Surface& surface, const py::object& labels, int threads) {
  const Array<std::int32_t> numbers = whole_numbers(labels, "labels");
  const auto label_of_triangle = values_of(numbers, "labels");
  expect_size("labels", label_of_triangle.size(), surface.num_triangles(), "triangles");
  const SurfaceView view = surface.view();
  return interruptible(threads, [&](const Execution& execution) {
    return std::make_unique<BorderLoops>(extract_label_borders(view, label_of_triangle, execution));
  });
}

/// The vertices along a loop; closed, the first is not repeated.
py::array vertices_of_loop(const BorderLoops& borders, const Surface& surface, std::size_t loop) {
  if (loop >= borders.num_loops()) throw py::index_error("there are " + std::to_string(borders.num_loops()) + " loops");
  const SurfaceView view = surface.view();
  std::vector<std::int32_t> vertices;
  for (auto e = static_cast<std::size_t>(borders.first_edge_of_loop[loop]);
       e < static_cast<std::size_t>(borders.first_edge_of_loop[loop + 1]); ++e) {
    const auto h = static_cast<std::size_t>(borders.half_edges[e]);
    if (h / 3 >= view.triangles.size()) throw py::value_error("the borders are not of this surface");
    vertices.push_back(view.triangles[h / 3][h % 3]);
  }
  return to_array(std::move(vertices));
}

/// Read-only arrays over a member of the object that holds it.
template <class Owner, class T>
auto view_property(std::vector<T> Owner::*member) {
  return [member](const py::object& self) { return view_of(self.cast<const Owner&>().*member, self); };
}

void declare_trees(py::module_& module) {
  py::class_<Surface>(module, "Surface",
                      "A triangle mesh over NumPy arrays. exclude: triangles that are taken out; edges to them become "
                      "rims. Raises StageError where an edge has more than two triangles or two that turn differently.")
      .def(py::init(&make_surface), py::arg("positions"), py::arg("triangles"), py::arg("exclude") = py::none(),
           py::arg("threads") = 0)
      .def_property_readonly("positions", [](const Surface& s) { return s.positions; })
      .def_property_readonly("triangles", [](const Surface& s) { return s.triangles; })
      .def_property_readonly("twins", view_property(&Surface::twins), "Twin of each half-edge 3 t + k; -1 at a rim.")
      .def_property_readonly("areas", view_property(&Surface::areas));

  py::class_<ComponentTree>(module, "ComponentTree",
                            "The tree of the components of {S >= h} (upper) or {S <= h} (lower), or of both with their "
                            "holes filled (shapes): parents after their children, a subtree is an interval.")
      .def_property_readonly("polarity", [](const ComponentTree& t) { return name_of(t.polarity); })
      .def_property_readonly("num_nodes", &ComponentTree::num_nodes)
      .def_property_readonly("levels", view_property(&ComponentTree::levels),
                             "Ascending, of -S for a lower tree; level k is levels[k - 1], but of shapes, whose nodes "
                             "count level lines from the root, the first being 1.")
      .def_property_readonly(
          "value",
          [](const ComponentTree& t) {
            std::vector<double> value(t.num_nodes());
            for (std::size_t n = 0; n < value.size(); ++n) value[n] = t.value(static_cast<std::int32_t>(n));
            return to_array(std::move(value));
          },
          "The scalar on the line around each node; infinite where there is none.")
      .def_property_readonly(
          "sign",
          [](const ComponentTree& t) {
            std::vector<std::int32_t> sign(t.num_nodes());
            for (std::size_t n = 0; n < sign.size(); ++n) sign[n] = t.sign(static_cast<std::int32_t>(n)) < 0 ? -1 : 1;
            return to_array(std::move(sign));
          },
          "1 where the scalar rises into a node from its line, -1 where it falls.")
      .def_property_readonly("parent", view_property(&ComponentTree::parent_of_node), "-1 for a root.")
      .def_property_readonly("high_level", view_property(&ComponentTree::hi_of_node))
      .def_property_readonly("low_level",
                             [](const ComponentTree& t) {
                               std::vector<std::int32_t> low(t.num_nodes());
                               for (std::size_t n = 0; n < low.size(); ++n) low[n] = t.lo(static_cast<std::int32_t>(n));
                               return to_array(std::move(low));
                             })
      .def_property_readonly("area",
                             [](const ComponentTree& t) {
                               std::vector<double> area(t.num_nodes());
                               for (std::size_t n = 0; n < area.size(); ++n)
                                 area[n] = area_of_node(t, static_cast<std::int32_t>(n));
                               return to_array(std::move(area));
                             })
      .def_property_readonly("first_node_of_subtree", view_property(&ComponentTree::first_node_of_subtree))
      .def_property_readonly("node_of_triangle", view_property(&ComponentTree::node_of_triangle),
                             "The smallest node that holds each triangle; -1: none.")
      .def_property_readonly("level_of_triangle", [](const ComponentTree& t) { return to_array(rebuild_levels(t)); })
      .def(
          "cut",
          [](const ComponentTree& t, double value) {
            if (std::isnan(value)) throw py::value_error("value: expected a number");
            return to_array(interruptible(0, [&](const Execution&) {
                              return cut_tree(t, level_of_value(t, value));
                            }).component_of_triangle);
          },
          py::arg("value"),
          "The component of each triangle in the level set at or next below a value of the scalar, numbered from 1 by "
          "decreasing area; 0: in none. Of shapes the smallest of those above and of those below the value.")
      .def(
          "simplify",
          [](const ComponentTree& t, double min_area, double min_persistence) {
            if (!(min_area >= 0)) throw py::value_error("min_area: expected a number, at least 0");
            if (!(min_persistence >= 0)) throw py::value_error("min_persistence: expected a number, at least 0");
            return interruptible(0, [&](const Execution&) {
              ComponentTree result = simplify_tree(t, nodes_of_area(t, min_area));
              return simplify_tree(result, nodes_of_persistence(result, min_persistence));
            });
          },
          py::arg("min_area") = 0.0, py::arg("min_persistence") = 0.0,
          "The tree without components smaller than min_area, then without maxima that last less than min_persistence.")
      .def(
          "reconstruct", [](const ComponentTree& t) { return to_array(reconstruct_triangle_values(t)); },
          "The scalar as the tree has it, one value a triangle; NaN in no node.");

  module.def("build_component_tree", &build_tree, py::arg("surface"), py::arg("values"), py::arg("levels") = 64,
             py::arg("range") = std::pair<double, double>(0.02, 0.98), py::arg("polarity") = "upper",
             py::arg("threads") = 0,
             "The component tree of a scalar, one value a vertex. levels: how many, equal steps between two quantiles "
             "(range), or the levels themselves, in units of the scalar.");
  module.def(
      "build_tree_of_shapes", &build_shapes, py::arg("surface"), py::arg("values"), py::arg("levels") = 64,
      py::arg("range") = std::pair<double, double>(0.02, 0.98), py::arg("root") = py::none(), py::arg("threads") = 0,
      "The tree of shapes of a scalar, one value a vertex: high and low regions within each other in one tree, "
      "holes in them filled. Select, label and describe as from a component tree; delta counts level lines. "
      "levels and range: as for build_component_tree. root: a vertex outside all regions; None: what lies beyond "
      "the longest rim, on a closed surface the place from which no region has more than half of the area. Raises "
      "StageError for a surface with a handle.");
  module.def(
      "stability",
      [](const ComponentTree& tree, std::int32_t delta) {
        return to_array(interruptible(0, [&](const Execution&) {
          const std::vector<std::int64_t> changes = change_of_nodes(tree, delta);
          std::vector<double> q(tree.num_nodes());
          for (std::size_t n = 0; n < q.size(); ++n)
            q[n] = stability_of_node(tree, changes, static_cast<std::int32_t>(n));
          return q;
        }));
      },
      py::arg("tree"), py::arg("delta") = 3, "q of every node: 0 is perfectly stable.");
  module.def("select_mser", &select, py::arg("surface"), py::arg("tree"), py::arg("delta") = 3,
             py::arg("against") = "children", "The maximally stable nodes, ascending.");
}

void declare_regions(py::module_& module) {
  py::class_<Regions>(module, "Regions", "Selected nodes, numbered from 1 by decreasing area, and each triangle's.")
      .def("__len__", [](const Regions& r) { return r.regions.size(); })
      .def_property_readonly("label_of_triangle", view_property(&Regions::label_of_triangle),
                             "The number of the smallest region that holds each triangle; 0: none.")
      .def_property_readonly("tree",
                             [](const Regions& r) {
                               std::vector<std::int32_t> trees;
                               for (const SelectedNode& region : r.regions) trees.push_back(region.tree);
                               return to_array(std::move(trees));
                             })
      .def_property_readonly("node", [](const Regions& r) {
        std::vector<std::int32_t> nodes;
        for (const SelectedNode& region : r.regions) nodes.push_back(region.node);
        return to_array(std::move(nodes));
      });
  module.def("label_triangles", &label, py::arg("trees"), py::arg("nodes"),
             "Regions of selected nodes: a list of trees of one mesh, and the nodes of each.");
  module.def("describe_regions", &attributes, py::arg("surface"), py::arg("regions"), py::arg("values"),
             py::arg("delta") = 3, py::arg("band") = py::none(),
             "Attributes of the regions, an array each, by name. band: the width on each side of a border, in units of "
             "the coordinates, over which contrast is measured; None: no contrast.");

  py::class_<BorderLoops>(module, "Borders",
                          "Closed loops of half-edges 3 t + k, the region on the left; loop i has the edges "
                          "first_edge_of_loop[i] to first_edge_of_loop[i + 1].")
      .def("__len__", &BorderLoops::num_loops)
      .def_property_readonly("owner_of_loop", view_property(&BorderLoops::owner_of_loop))
      .def_property_readonly("first_edge_of_loop", view_property(&BorderLoops::first_edge_of_loop))
      .def_property_readonly("half_edges", view_property(&BorderLoops::half_edges))
      .def_property_readonly("is_hole",
                             [](const BorderLoops& b) {
                               py::array_t<bool> holes(static_cast<py::ssize_t>(b.kinds.size()));
                               for (std::size_t e = 0; e < b.kinds.size(); ++e)
                                 holes.mutable_data()[e] = b.kinds[e] == EdgeKind::kHole;
                               return holes;
                             })
      .def_property_readonly("neighbours", view_property(&BorderLoops::neighbours),
                             "Number behind each edge: 0 background, -1 a hole.")
      .def_property_readonly("level_length_of_loop", view_property(&BorderLoops::level_length_of_loop))
      .def_property_readonly("hole_length_of_loop", view_property(&BorderLoops::hole_length_of_loop))
      .def_readonly("num_hole_loops_dropped", &BorderLoops::num_hole_loops_dropped)
      .def("vertices", &vertices_of_loop, py::arg("surface"), py::arg("loop"),
           "The vertices along a loop, the first not repeated.");
  module.def("extract_borders", &region_borders, py::arg("surface"), py::arg("regions"), py::arg("threads") = 0,
             "The borders of regions, nested ones included.");
  module.def("extract_label_borders", &label_borders, py::arg("surface"), py::arg("labels"), py::arg("threads") = 0,
             "The borders of patches of equal label; 0 is background.");
}

/// The closed list of errors, each under its own name.
void declare_errors(py::module_& module) {
  static py::exception<Error> error(module, "Error", PyExc_RuntimeError);
  static py::exception<UsageError> usage(module, "UsageError", error.ptr());
  static py::exception<ConfigError> config(module, "ConfigError", error.ptr());
  static py::exception<InputError> input(module, "InputError", error.ptr());
  static py::exception<StageError> stage(module, "StageError", error.ptr());
  static py::exception<CacheError> cache(module, "CacheError", error.ptr());
  static py::exception<Cancelled> cancelled(module, "Cancelled", error.ptr());
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& e) {
      switch (e.code()) {
        case ExitCode::kUsage:
          return usage(e.what());
        case ExitCode::kConfig:
          return config(e.what());
        case ExitCode::kInput:
          return input(e.what());
        case ExitCode::kStage:
          return stage(e.what());
        case ExitCode::kCache:
          return cache(e.what());
        case ExitCode::kInterrupted:
          return cancelled(e.what());
        default:
          return error(e.what());
      }
    }
  });
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  declare_errors(module);
  declare_trees(module);
  declare_regions(module);
  declare_run(module);
}

}  // namespace meshmser::python
