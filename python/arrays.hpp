#pragma once
/// NumPy arrays as the plain arrays of the library and back, without copies where types and order agree.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace meshmser::python {

namespace py = pybind11;

/// Taken as it is where its type and order are right, else converted by NumPy.
template <class T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double) && sizeof(std::array<std::int32_t, 3>) == 12,
              "rows of three lie side by side");

/// Ids and labels, which the library counts in 32 bits; what is no whole number or does not fit is refused rather than
/// cut. Throws TypeError or ValueError.
inline Array<std::int32_t> whole_numbers(const py::object& given, const std::string& name) {
  const py::array array = py::array::ensure(given);
  if (!array) throw py::type_error(name + ": expected an array of whole numbers");
  const char kind = array.dtype().kind();
  if (kind == 'b')
    throw py::type_error(name + ": expected whole numbers, got a mask; numpy.flatnonzero(mask) gives the numbers");
  if (kind != 'i' && kind != 'u' && array.size() > 0)
    throw py::type_error(name + ": expected whole numbers, got " + std::string(py::str(array.dtype())));
  if (array.size() > 0 && (array.itemsize() > 4 || kind == 'u')) {
    const py::int_ least(std::numeric_limits<std::int32_t>::min()), most(std::numeric_limits<std::int32_t>::max());
    if (py::object(array.attr("min")()) < least || py::object(array.attr("max")()) > most)
      throw py::value_error(name + ": a number does not fit into 32 bits");
  }
  return Array<std::int32_t>::ensure(array);
}

/// The values of a one-dimensional array. Throws ValueError otherwise.
template <class T>
std::span<const T> values_of(const Array<T>& array, const char* name) {
  if (array.ndim() != 1) throw py::value_error(std::string(name) + ": expected an array of one dimension");
  return {array.data(), static_cast<std::size_t>(array.size())};
}

/// The rows of an array of n by 3. Throws ValueError otherwise.
template <class Row, class T>
std::span<const Row> rows_of(const Array<T>& array, const char* name) {
  if (array.ndim() != 2 || array.shape(1) != 3)
    throw py::value_error(std::string(name) + ": expected an array of n rows of 3");
  return {reinterpret_cast<const Row*>(array.data()), static_cast<std::size_t>(array.shape(0))};
}

/// An array over memory that `owner` keeps, read-only.
template <class T>
py::array view_of(const std::vector<T>& values, py::handle owner) {
  py::array result(py::dtype::of<T>(), {values.size()}, {}, values.data(), owner);
  result.attr("flags").attr("writeable") = false;
  return result;
}

/// The vector's own memory as an array.
template <class T>
py::array to_array(std::vector<T> values) {
  auto kept = std::make_unique<std::vector<T>>(std::move(values));
  const std::vector<T>& here = *kept;
  const py::capsule owner(kept.release(), [](void* memory) { delete static_cast<std::vector<T>*>(memory); });
  return py::array(py::dtype::of<T>(), {here.size()}, {}, here.data(), owner);
}

/// The same of vectors of three: n by 3.
inline py::array to_array(std::vector<Eigen::Vector3d> values) {
  auto kept = std::make_unique<std::vector<Eigen::Vector3d>>(std::move(values));
  const std::vector<Eigen::Vector3d>& here = *kept;
  const py::capsule owner(kept.release(),
                          [](void* memory) { delete static_cast<std::vector<Eigen::Vector3d>*>(memory); });
  const double* data = here.empty() ? nullptr : here.front().data();
  return py::array(py::dtype::of<double>(), {here.size(), std::size_t{3}}, {}, data, owner);
}

}  // namespace meshmser::python
