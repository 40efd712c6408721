#include "pipeline/formats/stored_artifact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/execution/error.hpp"
#include "pipeline/execution/jobs.hpp"
#include "pipeline/formats/npy.hpp"

namespace meshmser {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kMainFile = "artifact.json";

// ---- Which field types there are. A type outside of them does not compile.

struct AnyField {
  template <class T>
  void operator()(const char*, T&&) const {}
};

template <class T>
concept Record = requires(T& value) {
  T::visit(value, AnyField{});
};
template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

template <class T>
struct OptionalOf {};
template <class T>
struct OptionalOf<std::optional<T>> {
  using type = T;
};
template <class T>
concept Optional = requires {
  typename OptionalOf<T>::type;
};

// An element of an array: its number type and how many there are.
template <class T>
struct Element {
  static constexpr bool known = false;
};
template <class T>
requires std::is_arithmetic_v<T>
struct Element<T> {
  static constexpr bool known = true;
  using Value = T;
  static constexpr std::uint64_t columns = 0;
};
template <class T>
requires std::is_enum_v<T>
struct Element<T> : Element<std::underlying_type_t<T>> {
};
template <class T, std::size_t N>
struct Element<std::array<T, N>> {
  static constexpr bool known = true;
  using Value = T;
  static constexpr std::uint64_t columns = N;
};
template <class T, int N>
struct Element<Eigen::Matrix<T, N, 1>> {
  static constexpr bool known = true;
  using Value = T;
  static constexpr std::uint64_t columns = N;
};

template <class T>
NpyShape shape_of(std::size_t rows) {
  using E = Element<T>;
  static_assert(sizeof(T) == sizeof(typename E::Value) * std::max<std::uint64_t>(1, E::columns));
  return {npy_type<typename E::Value>(), rows, E::columns};
}

// A column of flags is bytes: std::vector<bool> has no array to store.
template <class F>
using ColumnOf = std::vector<std::conditional_t<std::is_same_v<F, bool>, std::uint8_t, F>>;

// Whether every field of a record is a number or a small vector, so that a list of it can be stored by columns.
template <Record T>
bool is_flat() {
  bool flat = true;
  T example{};
  T::visit(example, [&]<class F>(const char*, F&) { flat = flat && Element<F>::known; });
  return flat;
}

// JSON has no form for infinity and NaN.
Json json_of(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

// ---- Writing

class Writer {
 public:
  explicit Writer(std::vector<StoredFile>& files) : files_(files) {}

  template <class T>
  Json put(const std::string& path, const T& value) {
    if constexpr (std::is_floating_point_v<T>) {
      return json_of(value);
    } else if constexpr (std::is_enum_v<T>) {
      return static_cast<std::underlying_type_t<T>>(value);
    } else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
      return value;
    } else if constexpr (Optional<T>) {
      return value ? put(path, *value) : Json();
    } else if constexpr (Element<T>::known) {
      Json list = Json::array();
      for (std::uint64_t i = 0; i < Element<T>::columns; ++i) list.push_back(put(path, value[static_cast<int>(i)]));
      return list;
    } else {
      static_assert(Record<T>);
      Json map = Json::object();
      T::visit(value, [&](const char* name, const auto& field) {
        map[name] = put(path.empty() ? name : path + "." + name, field);
      });
      return map;
    }
  }

  template <class T>
  Json put(const std::string& path, const std::vector<T>& values) {
    if constexpr (Element<T>::known) {
      return array(path, values, nullptr);
    } else {
      if constexpr (Record<T>) {
        if (is_flat<T>()) return columns(path, values);
      }
      Json list = Json::array();
      for (std::size_t i = 0; i < values.size(); ++i) list.push_back(put(path + "." + std::to_string(i), values[i]));
      return list;
    }
  }

 private:
  template <class T>
  Json array(const std::string& path, const std::vector<T>& values, std::shared_ptr<const void> keep) {
    const std::string name = path + ".npy";
    files_.push_back(
        {name, npy_header(shape_of<T>(values.size())), std::as_bytes(std::span<const T>(values)), std::move(keep)});
    return {{"array", name}};
  }

  template <Record T>
  Json columns(const std::string& path, const std::vector<T>& records) {
    Json map = {{"records", records.size()}, {"columns", Json::object()}};
    std::size_t wanted = 0;
    T example{};
    T::visit(example, [&]<class F>(const char* name, F&) {
      if constexpr (Element<F>::known) {
        auto column = std::make_shared<ColumnOf<F>>(records.size());
        for (std::size_t i = 0; i < records.size(); ++i) {
          std::size_t at = 0;
          T::visit(records[i], [&]<class G>(const char*, const G& field) {
            if constexpr (std::is_same_v<F, G>) {
              if (at == wanted) (*column)[i] = field;
            }
            ++at;
          });
        }
        map["columns"][name] = array(path + "." + name, *column, column);
      }
      ++wanted;
    });
    return map;
  }

  std::vector<StoredFile>& files_;
};

// ---- Reading

class Reader {
 public:
  explicit Reader(StoredFileSource& source) : source_(source) {}

  [[noreturn]] static void wrong(const std::string& path) {
    throw CacheError("artifact.json: " + path + " is not what was expected");
  }

  template <class T>
  void get(const std::string& path, const Json& json, T& value) {
    if constexpr (std::is_floating_point_v<T>) {
      if (json.is_number())
        value = json.get<T>();
      else if (json == "nan")
        value = std::numeric_limits<T>::quiet_NaN();
      else if (json == "inf" || json == "-inf")
        value = json == "inf" ? std::numeric_limits<T>::infinity() : -std::numeric_limits<T>::infinity();
      else
        wrong(path);
    } else if constexpr (std::is_enum_v<T>) {
      if (!json.is_number_integer()) wrong(path);
      value = static_cast<T>(json.get<std::underlying_type_t<T>>());
    } else if constexpr (std::is_same_v<T, bool>) {
      if (!json.is_boolean()) wrong(path);
      value = json.get<bool>();
    } else if constexpr (std::is_integral_v<T>) {
      if (!json.is_number_integer()) wrong(path);
      value = json.get<T>();
    } else if constexpr (std::is_same_v<T, std::string>) {
      if (!json.is_string()) wrong(path);
      value = json.get<std::string>();
    } else if constexpr (Optional<T>) {
      value.reset();
      if (!json.is_null()) get(path, json, value.emplace());
    } else if constexpr (Element<T>::known) {
      if (!json.is_array() || json.size() != Element<T>::columns) wrong(path);
      for (std::uint64_t i = 0; i < Element<T>::columns; ++i) get(path, json[i], value[static_cast<int>(i)]);
    } else {
      static_assert(Record<T>);
      if (!json.is_object()) wrong(path);
      T::visit(value, [&](const char* name, auto& field) {
        const std::string inner = path.empty() ? name : path + "." + name;
        if (!json.contains(name)) wrong(inner);
        get(inner, json[name], field);
      });
    }
  }

  template <class T>
  void get(const std::string& path, const Json& json, std::vector<T>& values) {
    if constexpr (Element<T>::known) {
      array(path, json, values);
    } else {
      if constexpr (Record<T>) {
        if (is_flat<T>()) return columns(path, json, values);
      }
      if (!json.is_array()) wrong(path);
      values.resize(json.size());
      for (std::size_t i = 0; i < values.size(); ++i) get(path + "." + std::to_string(i), json[i], values[i]);
    }
  }

  // Fills the arrays that `get` made room for.
  void finish(int threads) {
    run_jobs(jobs_.size(), threads, [&](std::size_t i) {
      const Job& job = jobs_[i];
      source_.read(job.name, job.header.size(), job.content);
      source_.check(job.name, std::as_bytes(std::span<const char>(job.header)), job.content);
    });
    for (const auto& scatter : scatters_) scatter();
  }

 private:
  struct Job {
    std::string name, header;
    std::span<std::byte> content;
  };

  template <class T>
  void array(const std::string& path, const Json& json, std::vector<T>& values) {
    if (!json.is_object() || !json.contains("array") || !json["array"].is_string()) wrong(path);
    const std::string name = json["array"].get<std::string>();
    const std::uint64_t size = source_.size(name);
    std::vector<std::byte> head(std::min<std::uint64_t>(size, kNpyHeaderLimit));
    source_.read(name, 0, head);
    const auto header = parse_npy_header(head);
    if (!header || header->shape != shape_of<T>(header->shape.rows) ||
        header->shape.rows != (size - header->size) / sizeof(T) || (size - header->size) % sizeof(T) != 0)
      throw CacheError(name + ": is not the array that was expected");
    values.resize(header->shape.rows);
    jobs_.push_back({name, std::string(reinterpret_cast<const char*>(head.data()), header->size),
                     std::as_writable_bytes(std::span<T>(values))});
  }

  template <Record T>
  void columns(const std::string& path, const Json& json, std::vector<T>& records) {
    if (!json.is_object() || !json.contains("records") || !json["records"].is_number_unsigned() ||
        !json.contains("columns"))
      wrong(path);
    const Json& columns = json["columns"];
    const auto count = json["records"].get<std::size_t>();
    std::size_t wanted = 0;
    T example{};
    T::visit(example, [&]<class F>(const char* name, F&) {
      if constexpr (Element<F>::known) {
        const std::string inner = path + "." + name;
        if (!columns.contains(name)) wrong(inner);
        auto column = std::make_shared<ColumnOf<F>>();
        array(inner, columns[name], *column);
        if (column->size() != count) wrong(inner);
        scatters_.push_back([&records, column, wanted, count] {
          records.resize(count);
          for (std::size_t i = 0; i < count; ++i) {
            std::size_t at = 0;
            T::visit(records[i], [&]<class G>(const char*, G& field) {
              if constexpr (std::is_same_v<F, G>) {
                if (at == wanted) field = static_cast<F>((*column)[i]);
              }
              ++at;
            });
          }
        });
      }
      ++wanted;
    });
  }

  StoredFileSource& source_;
  std::vector<Job> jobs_;
  std::vector<std::function<void()>> scatters_;
};

template <class T>
Artifact load_as(StoredFileSource& source, const std::filesystem::path& folder, int threads) {
  std::vector<std::byte> text(source.size(kMainFile));
  source.read(kMainFile, 0, text);
  source.check(kMainFile, {}, text);
  const Json json = Json::parse(reinterpret_cast<const char*>(text.data()),
                                reinterpret_cast<const char*>(text.data()) + text.size(), nullptr, false);
  if (!json.is_object() || !json.contains("type") || json["type"] != kArtifactInfo<T>.name ||
      !json.contains("version") || json["version"] != kArtifactInfo<T>.version || !json.contains("content"))
    Reader::wrong("its head");
  auto artifact = std::make_shared<T>();
  Reader reader(source);
  reader.get("", json["content"], *artifact);
  reader.finish(threads);
  if constexpr (std::is_same_v<T, FileSet>) artifact->folder = folder;
  return Shared<T>(std::move(artifact));
}

template <std::size_t I>
using ArtifactAt = std::remove_const_t<typename std::variant_alternative_t<I, Artifact>::element_type>;

// ---- Statistics

constexpr std::size_t kHistogramBins = 16;

class Statistician {
 public:
  explicit Statistician(std::vector<FieldStatistics>& fields) : fields_(fields) {}

  template <class T>
  void look(const std::string& path, const T& value) {
    if constexpr (Optional<T>) {
      if (value)
        look(path, *value);
      else
        fields_.push_back({path, "none"});
    } else if constexpr (Number<T> || Element<T>::known || std::is_same_v<T, std::string>) {
      std::vector<StoredFile> none;
      fields_.push_back({path, Writer(none).put(path, value).dump()});
    } else {
      static_assert(Record<T>);
      T::visit(value,
               [&](const char* name, const auto& field) { look(path.empty() ? name : path + "." + name, field); });
    }
  }

  template <class T>
  void look(const std::string& path, const std::vector<T>& values) {
    if constexpr (Element<T>::known) {
      array(path, values);
    } else {
      if constexpr (Record<T>) {
        if (is_flat<T>()) return columns(path, values);
      }
      if (values.empty()) fields_.push_back({path, "[]"});
      for (std::size_t i = 0; i < values.size(); ++i) look(path + "." + std::to_string(i), values[i]);
    }
  }

 private:
  template <class T>
  void array(const std::string& path, const std::vector<T>& values) {
    using Value = typename Element<T>::Value;
    const std::size_t width = std::max<std::uint64_t>(1, Element<T>::columns);
    FieldStatistics field{path, ""};
    field.type = npy_type<Value>();
    field.shape = {values.size()};
    if (Element<T>::columns > 0) field.shape.push_back(Element<T>::columns);
    const auto* data = reinterpret_cast<const Value*>(values.data());
    for (std::size_t c = 0; c < width; ++c)
      field.columns.push_back(
          column(values.size(), [&](std::size_t i) { return static_cast<double>(data[i * width + c]); }));
    fields_.push_back(std::move(field));
  }

  template <class Value>
  static FieldStatistics::Column column(std::size_t size, Value&& value) {
    FieldStatistics::Column c;
    c.least = std::numeric_limits<double>::infinity();
    c.greatest = -c.least;
    double sum = 0;
    std::uint64_t finite = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const double v = value(i);
      if (!std::isfinite(v)) continue;
      ++finite;
      sum += v;
      c.least = std::min(c.least, v);
      c.greatest = std::max(c.greatest, v);
    }
    c.num_not_finite = size - finite;
    if (finite == 0) return {0, 0, 0, c.num_not_finite};
    c.mean = sum / static_cast<double>(finite);
    c.histogram.assign(c.greatest > c.least ? kHistogramBins : 1, 0);
    const double scale = static_cast<double>(c.histogram.size()) / std::max(c.greatest - c.least, 1e-300);
    for (std::size_t i = 0; i < size; ++i) {
      const double v = value(i);
      if (!std::isfinite(v)) continue;
      const auto bin = static_cast<std::size_t>((v - c.least) * scale);
      ++c.histogram[std::min(bin, c.histogram.size() - 1)];
    }
    return c;
  }

  template <Record T>
  void columns(const std::string& path, const std::vector<T>& records) {
    std::vector<StoredFile> files;
    Writer(files).put(path, records);
    T example{};
    std::size_t at = 0;
    T::visit(example, [&]<class F>(const char* name, F&) {
      if constexpr (Element<F>::known) {
        const auto* values = static_cast<const ColumnOf<F>*>(files[at++].keep.get());
        array(path + "." + name, *values);
      }
    });
  }

  std::vector<FieldStatistics>& fields_;
};

}  // namespace

std::vector<StoredFile> stored_files(const Artifact& artifact) {
  std::vector<StoredFile> files(1);
  std::visit(
      [&]<class T>(const Shared<T>& value) {
        Json json;
        json["type"] = kArtifactInfo<T>.name;
        json["version"] = kArtifactInfo<T>.version;
        json["content"] = Writer(files).put("", *value);
        auto text = std::make_shared<std::string>(json.dump(1) + "\n");
        files[0] = {kMainFile, "", std::as_bytes(std::span<const char>(*text)), text};
      },
      artifact);
  return files;
}

Artifact load_stored_artifact(std::size_t type, StoredFileSource& source, const std::filesystem::path& folder,
                              int threads) {
  using Loader = Artifact (*)(StoredFileSource&, const std::filesystem::path&, int);
  static const auto loaders = []<std::size_t... I>(std::index_sequence<I...>) {
    return std::array<Loader, sizeof...(I)>{&load_as<ArtifactAt<I>>...};
  }
  (std::make_index_sequence<std::variant_size_v<Artifact>>());
  return loaders.at(type)(source, folder, threads);
}

std::vector<FieldStatistics> field_statistics(const Artifact& artifact) {
  std::vector<FieldStatistics> fields;
  std::visit([&](const auto& value) { Statistician(fields).look("", *value); }, artifact);
  return fields;
}

}  // namespace meshmser
