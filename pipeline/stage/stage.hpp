#pragma once
/// The stage interface: what a stage tells of itself, what it is given when it runs, and the registry of all stages.

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "pipeline/artifacts/artifact.hpp"
#include "pipeline/artifacts/scalar_fields.hpp"
#include "pipeline/execution/execution.hpp"
#include "pipeline/stage/parameter.hpp"

namespace meshmser {

/// Name (also the config's), version (raised whenever the same inputs give another result) and purpose in one sentence.
struct StageInfo {
  std::string_view name;
  int version;
  std::string_view purpose;
};

enum class Need {
  kRequired,  ///< exactly one: the nearest earlier stage's that makes the type
  kOptional,  ///< the nearest earlier one, if any
  kAll        ///< those of all earlier stages, in their order (the stage's `choose` may narrow them)
};

struct InputPort {
  std::string name;
  std::size_t type;  ///< index into Artifact
  Need need;
};
struct OutputPort {
  std::string name;
  std::size_t type;
};

/// Index of Shared<T> in Artifact.
template <class T>
constexpr std::size_t artifact_index() {
  return []<std::size_t... I>(std::index_sequence<I...>) {
    std::size_t found = 0;
    ((std::is_same_v<std::variant_alternative_t<I, Artifact>, Shared<T>> ? (found = I, true) : false) || ...);
    return found;
  }
  (std::make_index_sequence<std::variant_size_v<Artifact>>());
}
/// Name of the artifact type with that index.
std::string_view artifact_name(std::size_t index);

/// What a stage declares: parameters and ports.
class StageSchema : public Schema {
 public:
  /// An input of type T, by name.
  template <class T>
  void input(std::string_view name, Need need = Need::kRequired) {
    inputs_.push_back({std::string(name), artifact_index<T>(), need});
  }
  template <class T>
  void output(std::string_view name) {
    outputs_.push_back({std::string(name), artifact_index<T>()});
  }
  const std::vector<InputPort>& inputs() const { return inputs_; }
  const std::vector<OutputPort>& outputs() const { return outputs_; }

 private:
  std::vector<InputPort> inputs_;
  std::vector<OutputPort> outputs_;
};

/// The artifacts a stage was given.
class Inputs {
 public:
  struct Item {
    std::string port;
    std::string stage;  ///< the name in the config of the stage that made it
    Artifact artifact;
  };
  void add(Item item) { items_.push_back(std::move(item)); }

  /// The artifact at a port; throws a StageError where it is not there.
  template <class T>
  const T& get(std::string_view port) const {
    if (const T* found = find<T>(port)) return *found;
    throw StageError("input '" + std::string(port) + "' is missing");
  }
  /// The artifact at a port, or nullptr.
  template <class T>
  const T* find(std::string_view port) const {
    for (const Item& item : items_)
      if (item.port == port) return std::get<Shared<T>>(item.artifact).get();
    return nullptr;
  }
  /// Every artifact at a port with the name of its stage, in the order of the stages.
  template <class T>
  std::vector<std::pair<std::string, const T*>> all(std::string_view port) const {
    std::vector<std::pair<std::string, const T*>> found;
    for (const Item& item : items_)
      if (item.port == port) found.emplace_back(item.stage, std::get<Shared<T>>(item.artifact).get());
    return found;
  }

 private:
  std::vector<Item> items_;
};

/// The artifacts a stage made.
class Outputs {
 public:
  template <class T>
  void set(std::string_view port, T value) {
    items_.emplace_back(std::string(port), Artifact(std::make_shared<const T>(std::move(value))));
  }
  const std::vector<std::pair<std::string, Artifact>>& items() const { return items_; }

 private:
  std::vector<std::pair<std::string, Artifact>> items_;
};

/// A figure that a stage tells of its work, for `run`, `show` and run.json.
struct ReportItem {
  std::string name;  ///< snake_case: num_duplicates, sigma_mean_curvature
  std::variant<std::int64_t, double, std::string> value;
  std::string unit;  ///< "" for a plain count
};

/// What a running stage may use beside its inputs. Warnings and report are stored with the result and told again when
/// the result is taken from the cache.
class RunContext {
 public:
  RunContext(Execution execution, std::filesystem::path scratch, std::string stage_name = "",
             std::string units = "unit")
      : execution_(std::move(execution)),
        scratch_(std::move(scratch)),
        stage_name_(std::move(stage_name)),
        units_(std::move(units)) {}

  const Execution& execution() const { return execution_; }
  /// The stage's name in the config.
  const std::string& stage_name() const { return stage_name_; }
  /// Unit of the coordinates, for messages and scale bars.
  const std::string& units() const { return units_; }
  /// An empty folder for a FileSet's files.
  const std::filesystem::path& scratch_folder() const { return scratch_; }
  /// A sentence for the user: what is doubtful, and what to do.
  void warn(std::string message) { warnings_.push_back(std::move(message)); }
  /// Tells of a value that was given for another rule than the one at work.
  void warn_if_idle(bool is_idle, std::string_view parameter, std::string_view used_by) {
    if (is_idle)
      warn(std::string(parameter) + " is given but changes nothing: only " + std::string(used_by) + " uses it");
  }
  /// `unit`: for people, but a scalar's own unit will do.
  void report(std::string name, std::int64_t value, std::string unit = "") {
    report_.push_back({std::move(name), value, unit_for_people(std::move(unit), units_)});
  }
  void report(std::string name, double value, std::string unit = "") {
    report_.push_back({std::move(name), value, unit_for_people(std::move(unit), units_)});
  }
  void report(std::string name, std::string value) { report_.push_back({std::move(name), std::move(value), ""}); }

  const std::vector<std::string>& warnings() const { return warnings_; }
  const std::vector<ReportItem>& report_items() const { return report_; }

 private:
  Execution execution_;
  std::filesystem::path scratch_;
  std::string stage_name_, units_;
  std::vector<std::string> warnings_;
  std::vector<ReportItem> report_;
};

/// What is wrong between parameters that are each right alone: the parameter to blame and a message.
using ParameterProblem = std::pair<std::string, std::string>;

/// A stage without its types: what the pipeline works with.
struct StageDefinition {
  StageInfo info;
  std::vector<Parameter> parameters;
  std::vector<InputPort> inputs;
  std::vector<OutputPort> outputs;
  std::function<std::shared_ptr<void>()> make_parameters;  ///< the defaults
  std::function<Outputs(const void* parameters, const Inputs&, RunContext&)> run;
  /// Files the stage will read; their contents belong to the cache key. Throws an InputError where it must look into
  /// one to know and cannot.
  std::function<std::vector<std::filesystem::path>(const void* parameters)> files;
  /// Names of the output ports that will be made with these parameters (may look at the head of an input file).
  std::function<std::vector<std::string>(const void* parameters)> made_outputs;
  /// Which of the `available` stages' artifacts a kAll port wants.
  std::function<std::vector<std::string>(const void* parameters, std::string_view port,
                                         const std::vector<std::string>& available)>
      choose;
  std::function<std::vector<ParameterProblem>(const void* parameters)> check;
};

/// Beside info, Parameters, declare and run, a stage S may have
///   static std::vector<std::filesystem::path> files(const Parameters&);
///   static std::vector<std::string> made_outputs(const Parameters&);
///   static std::vector<std::string> choose(const Parameters&, std::string_view port,
///                                          const std::vector<std::string>& available);
///   static std::vector<ParameterProblem> check(const Parameters&);
template <class S>
StageDefinition define_stage() {
  using P = typename S::Parameters;
  StageSchema schema;
  S::declare(schema);
  StageDefinition d;
  d.info = S::info;
  d.parameters = schema.parameters();
  d.inputs = schema.inputs();
  d.outputs = schema.outputs();
  d.make_parameters = [] { return std::static_pointer_cast<void>(std::make_shared<P>()); };
  d.run = [](const void* p, const Inputs& inputs, RunContext& context) {
    return S::run(*static_cast<const P*>(p), inputs, context);
  };
  d.files = [](const void* p) -> std::vector<std::filesystem::path> {
    if constexpr (requires(const P& q) { S::files(q); }) return S::files(*static_cast<const P*>(p));
    return (void)p, std::vector<std::filesystem::path>{};
  };
  d.made_outputs = [outputs = d.outputs](const void* p) {
    if constexpr (requires(const P& q) { S::made_outputs(q); }) return S::made_outputs(*static_cast<const P*>(p));
    std::vector<std::string> names;
    for (const OutputPort& port : outputs) names.push_back(port.name);
    return (void)p, names;
  };
  d.choose = [](const void* p, std::string_view port, const std::vector<std::string>& available) {
    if constexpr (requires(const P& q) { S::choose(q, port, available); })
      return S::choose(*static_cast<const P*>(p), port, available);
    return (void)p, (void)port, available;
  };
  d.check = [](const void* p) -> std::vector<ParameterProblem> {
    if constexpr (requires(const P& q) { S::check(q); }) return S::check(*static_cast<const P*>(p));
    return (void)p, std::vector<ParameterProblem>{};
  };
  return d;
}

/// Adds a stage; to be called by MESHMSER_STAGE only. A repeated name is a programming error (std::logic_error).
bool register_stage(StageDefinition definition);
/// All stages, by name.
std::vector<const StageDefinition*> all_stages();
/// The stage of that name, or nullptr.
const StageDefinition* find_stage(std::string_view name);

#define MESHMSER_STAGE(Type) \
  [[maybe_unused]] static const bool registered_##Type = ::meshmser::register_stage(::meshmser::define_stage<Type>())

}  // namespace meshmser
