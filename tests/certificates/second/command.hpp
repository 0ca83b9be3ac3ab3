// The command line of a checker, and the limits that it gives.
#pragma once

#include "basics.hpp"

struct Clock {
  std::size_t most = 10'000'000;
  double seconds = 1e9;
  std::chrono::steady_clock::time_point begun = std::chrono::steady_clock::now();
  void look(std::size_t states) const {
    if (states > most) throw Limit("more than " + std::to_string(most) + " states");
    if (std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count() > seconds) throw Limit("the seconds are over");
  }
};

// What a checker's command line asks for: the bound that it names, seconds, and the file. Exit code 2: not checked.
template <class Checked> int answered(int count, char** words, const std::string& bound, Checked checked) {
  Clock clock;
  std::string path;
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    if (word == bound && i + 1 < count) clock.most = std::strtoull(words[++i], nullptr, 10);
    else if (word == "--seconds" && i + 1 < count) clock.seconds = std::strtod(words[++i], nullptr);
    else path = word;
  }
  try {
    return checked(path, clock);
  } catch (const Malformed& error) {
    std::cerr << path << ": malformed: " << error.what() << '\n';
  } catch (const std::exception& error) {
    std::cerr << path << ": " << error.what() << '\n';
  }
  return 2;
}
