#include <cstdio>

#include "pipeline/cli/commands.hpp"
#include "pipeline/config/describe.hpp"

namespace meshmser {

CommandDefinition schema_command() {
  return {.name = "schema",
          .purpose = "Writes the JSON Schema of configurations, with which editors check and complete them.",
          .options = {},
          .run =
              [](const CommandArguments&, CommandHost&) {
                std::fputs(json_schema().c_str(), stdout);
                return 0;
              },
          .example = "meshmser schema > meshmser.schema.json"};
}

}  // namespace meshmser
