#include "pipeline/cli/command_line.hpp"

int main(int argc, char** argv) {
  return meshmser::run_command_line(argc, argv);
}
