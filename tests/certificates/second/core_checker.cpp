// A second checker of core missions beside nets, written from docs/certificates.md alone: c++ -O2 -std=c++17 core_checker.cpp -o core_checker.
//
// core_checker FILE [--max-states N] [--seconds S] prints "proved net", "refuted net" or "not checked net", and ends with 0, 1 or 2.
// Why a net is refuted or not checked is told in one sentence.
#include "play.hpp"
#include "listing.hpp"

std::set<Role> look_of(const Net& net, const Marking& marking) {
  static const std::set<std::string> ends{"begin", "success", "failure", "abort"};
  static const std::set<std::string> known{"objective", "pending", "done", "active", "wait", "refused", "oos", "known", "fact", "happened"};
  std::set<Role> found;
  for (std::size_t p = 0; p < net.places.size(); ++p) {
    if (!marking[p]) continue;
    for (const auto& [role, element] : net.places[p].roles) {
      if (ends.count(role)) found.emplace(role, "");
      else if (role == "want") found.emplace("wait", element);
      else if (known.count(role)) found.emplace(role, element);
    }
  }
  return found;
}

void walk(const Net& net, const States& states, const Core& core, const Clock& clock) {
  const Play play(core, clock);
  std::vector<std::set<Role>> looks;
  for (const Marking& each : states.markings) looks.push_back(look_of(net, each));
  std::set<std::pair<std::size_t, std::string>> seen;
  std::vector<std::pair<std::size_t, State>> open;
  const auto told = [](const Texts& event) { return event[0] + " of " + event[1] + (event.size() == 3 ? " for " + event[2] : ""); };
  const auto next = [&](std::size_t s, const State& state) {
    if (!seen.emplace(s, key_of(state)).second) return;
    open.emplace_back(s, state);
  };
  if (const State first = play.first(); play.look(first) == looks[0]) next(0, first);
  else throw Refuted("state 0 does not say what the mission does before its start");
  std::size_t count = 0;
  while (!open.empty()) {
    clock.look(seen.size());
    const auto [s, state] = std::move(open.back());
    open.pop_back();
    const std::set<Texts> expected = play.events(state);
    std::set<Texts> found;
    for (const Edge& edge : states.edges[s]) {
      const Texts& event = net.transitions[std::size_t(edge.transition)].event;
      if (!found.insert(event).second) throw Refuted("state " + std::to_string(s) + " has twice " + told(event));
      if (!expected.count(event)) throw Refuted("in state " + std::to_string(s) + " there is, and may not happen, " + told(event));
    }
    for (const Texts& event : expected)
      if (!found.count(event)) throw Refuted("in state " + std::to_string(s) + " may happen, and there is not, " + told(event));
    for (const Edge& edge : states.edges[s]) {
      const Texts& event = net.transitions[std::size_t(edge.transition)].event;
      bool alike = false;
      for (const auto& [_, end] : play.after(state, event)) {
        if (play.look(end) != looks[edge.to]) continue;
        alike = true;
        next(edge.to, end);
      }
      ++count;
      if (!alike) throw Refuted("from state " + std::to_string(s) + ", to state " + std::to_string(edge.to) + ", other things come of " + told(event));
    }
  }
  std::cerr << seen.size() << " pairs of states, " << count << " events\n";
}

int checked(const std::string& path, const Clock& clock) {
  const auto files = unzipped(path);
  require(files.count("core.json") > 0, "there is no entry core.json");
  const Net net = net_of(parsed(files.at("net.json")));
  const Core core(parsed(files.at("core.json")));  // whatever is malformed is so before anything is refuted
  try {
    const States states(net, clock);
    walk(net, states, core, clock);
  } catch (const Unsafe&) {
    throw Refuted("the net is not safe");
  } catch (const NotConfluent&) {
    throw Refuted("the net is not confluent");
  }
  std::cout << "proved net\n";
  return 0;
}

int main(int count, char** words) {
  return answered(count, words, "--max-states", [](const std::string& path, const Clock& clock) {
    try {
      return checked(path, clock);
    } catch (const Refuted& error) {
      std::cout << "refuted net\n";
      std::cerr << path << ": " << error.what() << '\n';
      return 1;
    } catch (const std::exception&) {
      std::cout << "not checked net\n";
      throw;
    }
  });
}
