#include "pipeline/config/yaml.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <string_view>

namespace meshmser {
namespace {

// Thrown where reading on makes no sense; the diagnostic is already there.
struct GiveUp {};

std::size_t num_values(const ConfigValue& value) {
  std::size_t count = 1;
  for (const ConfigValue& item : value.items) count += num_values(item);
  for (const auto& [key, entry] : value.entries) count += num_values(entry);
  return count;
}

// Builds the tree of values from the parser's events: unlike YAML::Node they tell the place of everything, show a
// repeated key twice, and never follow an alias by themselves.
class ValueBuilder : public YAML::EventHandler {
 public:
  ValueBuilder(const std::string& file, std::vector<Diagnostic>& problems) : file_(file), problems_(problems) {}

  ConfigValue take() { return std::move(root_); }

  /// Where the innermost list or map begins that is still open; nullptr: none is.
  const Location* open_location() const { return stack_.empty() ? nullptr : &stack_.back().value.location; }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (num_documents_++ > 0) give_up(place(mark), "a second document begins here; a configuration is one document");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    ConfigValue value;
    // The mark of an empty value is that of whatever comes next; its key says better where it is.
    value.location = pending_key() ? stack_.back().key_location : place(mark);
    add(std::move(value), anchor);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    check_tag(mark, tag);
    ConfigValue value;
    value.kind = ConfigValue::Kind::kScalar;
    value.text = text;
    value.quoted = tag == "!";
    value.location = place(mark);
    add(std::move(value), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = value_of_anchor_.find(anchor);
    if (found == value_of_anchor_.end()) give_up(place(mark), "this alias stands inside the value that it names");
    count(place(mark), num_values(found->second) - 1);
    ConfigValue value = found->second;
    value.location = place(mark);
    add(std::move(value), YAML::NullAnchor);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    check_tag(mark, tag);
    open(mark, ConfigValue::Kind::kList, anchor);
  }
  void OnSequenceEnd() override { close(); }

  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    check_tag(mark, tag);
    open(mark, ConfigValue::Kind::kMap, anchor);
  }
  void OnMapEnd() override { close(); }

 private:
  // An open list or map; of a map, the key whose value comes next.
  struct Open {
    ConfigValue value;
    YAML::anchor_t anchor = YAML::NullAnchor;
    bool has_key = false;
    bool repeated = false;
    std::string key;
    Location key_location;
  };

  Location place(const YAML::Mark& mark) const { return {file_, mark.line + 1, mark.column + 1}; }

  [[noreturn]] void give_up(const Location& location, std::string message) {
    problems_.push_back({location, std::move(message)});
    throw GiveUp{};
  }

  void count(const Location& location, std::size_t more) {
    num_values_ += more;
    if (num_values_ > kMaxConfigValues)
      give_up(location, "more than " + std::to_string(kMaxConfigValues) +
                            " values, aliases copied in; a configuration has fewer");
  }

  void check_tag(const YAML::Mark& mark, const std::string& tag) {
    if (!tag.empty() && tag != "?" && tag != "!")
      problems_.push_back({place(mark), "tags ('" + tag + "') have no meaning here; write the value alone"});
  }

  bool pending_key() const {
    return !stack_.empty() && stack_.back().value.kind == ConfigValue::Kind::kMap && stack_.back().has_key;
  }

  void open(const YAML::Mark& mark, ConfigValue::Kind kind, YAML::anchor_t anchor) {
    if (static_cast<int>(stack_.size()) >= kMaxConfigDepth)
      give_up(place(mark), "nested more than " + std::to_string(kMaxConfigDepth) + " deep");
    Open level;
    level.value.kind = kind;
    level.value.location = place(mark);
    level.anchor = anchor;
    stack_.push_back(std::move(level));
  }

  void close() {
    Open level = std::move(stack_.back());
    stack_.pop_back();
    add(std::move(level.value), level.anchor);
  }

  // Puts a finished value where it belongs: the root, an item, a key, or the value of the key before it.
  void add(ConfigValue value, YAML::anchor_t anchor) {
    count(value.location, 1);
    if (anchor != YAML::NullAnchor) value_of_anchor_[anchor] = value;
    if (stack_.empty()) {
      root_ = std::move(value);
      return;
    }
    Open& parent = stack_.back();
    if (parent.value.kind == ConfigValue::Kind::kList) {
      parent.value.items.push_back(std::move(value));
    } else if (!parent.has_key) {
      take_key(parent, value);
    } else {
      parent.has_key = false;
      if (parent.repeated) return;
      parent.value.entries.emplace_back(parent.key, std::move(value));
      parent.value.key_locations.push_back(parent.key_location);
    }
  }

  void take_key(Open& parent, const ConfigValue& key) {
    parent.has_key = true;
    parent.repeated = true;  // a key that cannot be used takes its value along
    if (key.kind != ConfigValue::Kind::kScalar) {
      problems_.push_back({key.location, "a key must be a word"});
      return;
    }
    for (std::size_t i = 0; i < parent.value.entries.size(); ++i)
      if (parent.value.entries[i].first == key.text) {
        const Location& first = parent.value.key_locations[i];
        problems_.push_back({key.location, "key '" + key.text + "' stands here again; it was already given in line " +
                                               std::to_string(first.line)});
        return;
      }
    parent.repeated = false;
    parent.key = key.text;
    parent.key_location = key.location;
  }

  const std::string& file_;
  std::vector<Diagnostic>& problems_;
  ConfigValue root_;
  std::vector<Open> stack_;
  std::map<YAML::anchor_t, ConfigValue> value_of_anchor_;
  std::size_t num_values_ = 0;
  int num_documents_ = 0;
};

void report(std::vector<Diagnostic>& problems, const std::string& file, int line, int column, std::string message) {
  Diagnostic diagnostic;
  diagnostic.location = {file, line, column};
  diagnostic.message = std::move(message);
  problems.push_back(std::move(diagnostic));
}

// The parser's words where they help nobody.
std::string plain_words(const std::string& message) {
  if (message == "end of map not found" || message == "end of sequence not found")
    return "the indentation of this line fits nothing above it";
  if (message == "illegal block entry") return "a '-' cannot stand here; lines are indented by blanks, not tabs";
  return message;
}

// The first byte that no text file has, or npos.
std::size_t first_control_byte(std::string_view text) {
  const auto found = std::find_if(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte == 0x7F || (byte < 0x20 && c != '\n' && c != '\r' && c != '\t');
  });
  return found == text.end() ? std::string_view::npos : static_cast<std::size_t>(found - text.begin());
}

void set_locations(ConfigValue& value, const Location& location) {
  value.location = location;
  for (ConfigValue& item : value.items) set_locations(item, location);
  for (auto& [key, entry] : value.entries) set_locations(entry, location);
  std::fill(value.key_locations.begin(), value.key_locations.end(), location);
}

}  // namespace

ConfigValue read_yaml(const std::string& text, const std::string& file, std::vector<Diagnostic>& problems) {
  if (text.size() > kMaxConfigBytes) {
    report(problems, file, 1, 1,
           "more than " + std::to_string(kMaxConfigBytes) +
               " bytes, no configuration is so large; where it is a scan, 'meshmser init' writes a configuration "
               "for it");
    return {};
  }
  if (const std::size_t at = first_control_byte(text); at != std::string::npos) {
    const auto line = static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
    const std::size_t before = text.rfind('\n', at);
    const auto column = static_cast<int>(before == std::string::npos ? at : at - before - 1);
    report(problems, file, line + 1, column + 1, "a control byte; this is not a text file");
    return {};
  }
  ValueBuilder builder(file, problems);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) continue;
  } catch (const GiveUp&) {
  } catch (const YAML::Exception& error) {
    // The parser names the end of the text where a bracket is not closed; where it was opened is of more use.
    const bool map_open = error.msg == "end of map flow not found";
    const bool list_open = error.msg == "end of sequence flow not found";
    const bool known = error.mark.line >= 0 && error.mark.column >= 0;
    if ((map_open || list_open) && builder.open_location() != nullptr) {
      const Location& place = *builder.open_location();
      report(problems, file, place.line, place.column,
             map_open ? "not valid YAML: this map is not closed by '}'"
                      : "not valid YAML: this list is not closed by ']'");
    } else {
      report(problems, file, known ? error.mark.line + 1 : 1, known ? error.mark.column + 1 : 1,
             "not valid YAML: " + plain_words(error.msg));
    }
  }
  return builder.take();
}

ConfigValue read_argument_value(const std::string& text, const std::string& argument,
                                std::vector<Diagnostic>& problems) {
  std::vector<Diagnostic> found;
  ConfigValue value = read_yaml(text, argument, found);
  const Location location{argument, 0, 0};
  set_locations(value, location);
  for (Diagnostic& problem : found) problems.push_back({location, std::move(problem.message)});
  return value;
}

}  // namespace meshmser
