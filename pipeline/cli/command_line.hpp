#pragma once
/// The command line: arguments to commands, errors to messages and exit codes.

namespace meshmser {

/// Runs the program. Results go to stdout, messages to stderr; returns the exit code (ExitCode in
/// pipeline/execution/error.hpp). Interrupts and termination requests cancel what runs.
int run_command_line(int argc, const char* const* argv);

}  // namespace meshmser
