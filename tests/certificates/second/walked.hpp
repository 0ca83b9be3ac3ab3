// The command of a checker of controllers: it reads a certificate and a controller, walks both, and says its verdict.
#pragma once

#include "command.hpp"
#include "listing.hpp"
#include "robot.hpp"

// The controller of a file.
inline Controller controller_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  require(bool(file), "a controller that cannot be read");
  Json document = parsed(std::string((std::istreambuf_iterator<char>(file)), {}), true);
  require(document.kind == Json::object, "a controller that is no object");
  return Controller(std::move(document));
}

// Asks a walk, which is given the certificate, the controller and the limits, and says what it walked.
template <class Walked> int verdict_on_controller(int count, char** words, Walked walked) {
  if (count < 3) {
    std::cerr << "usage: " << words[0] << " CERTIFICATE CONTROLLER [--max-states N] [--seconds S]\n";
    return 2;
  }
  const std::string certificate = words[1];
  return answered(count - 1, words + 1, "--max-states", [&](const std::string& path, const Clock& clock) {
    try {
      const std::string walk = walked(certificate, path, clock);
      std::cout << "proved controller: " << walk << '\n';
      return 0;
    } catch (const Refuted& why) {
      std::cout << "refuted controller: " << why.what() << '\n';
      return 1;
    } catch (const Unsafe&) {
      std::cout << "not checked controller: the net is not safe\n";
    } catch (const NotConfluent&) {
      std::cout << "not checked controller: the net is not confluent\n";
    } catch (const Limit& limit) {
      std::cout << "not checked controller: " << limit.what() << '\n';
    }
    return 2;
  });
}
