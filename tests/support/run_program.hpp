#pragma once
/// Runs the program as a user does.

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <vector>

namespace meshmser {

struct Finished {
  int exit_code = -1;  ///< 128 + signal where a signal ended it
  std::string out, err;
  double seconds = 0;
};

/// Runs `meshmser` with these arguments in the folder. Where `interrupt_at` is given, SIGINT is sent once that text
/// stands in what was written to stderr.
inline Finished run_program(const std::vector<std::string>& arguments, const std::string& folder,
                            const std::string& interrupt_at = "") {
  int out[2], err[2];
  if (pipe(out) != 0 || pipe(err) != 0) return {};
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0) {
    dup2(out[1], STDOUT_FILENO);
    dup2(err[1], STDERR_FILENO);
    for (const int end : {out[0], out[1], err[0], err[1]}) close(end);
    std::vector<char*> words;
    std::string program = MESHMSER_PROGRAM;
    words.push_back(program.data());
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    if (chdir(folder.c_str()) != 0) _exit(99);
    execv(words[0], words.data());
    _exit(98);
  }
  close(out[1]);
  close(err[1]);
  Finished finished;
  bool interrupted = interrupt_at.empty();
  pollfd ends[2] = {{out[0], POLLIN, 0}, {err[0], POLLIN, 0}};
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    poll(ends, 2, -1);
    for (int k = 0; k < 2; ++k) {
      if (ends[k].fd < 0 || ends[k].revents == 0) continue;
      char buffer[4096];
      const ssize_t size = read(ends[k].fd, buffer, sizeof buffer);
      if (size > 0)
        (k == 0 ? finished.out : finished.err).append(buffer, static_cast<std::size_t>(size));
      else
        ends[k].fd = -1;
    }
    if (!interrupted && finished.err.find(interrupt_at) != std::string::npos) {
      interrupted = true;
      kill(child, SIGINT);
    }
  }
  close(out[0]);
  close(err[0]);
  int status = 0;
  waitpid(child, &status, 0);
  finished.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  finished.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return finished;
}

}  // namespace meshmser
