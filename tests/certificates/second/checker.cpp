// A second checker of certificates, written from docs/certificates.md alone: c++ -O2 -std=c++17 checker.cpp -o checker.
//
// checker FILE [--max-states N] [--seconds S] prints "VERDICT KEY" for each claim, where VERDICT is proved, refuted or not checked,
// and ends with 0 if all are proved, 1 if some is refuted, else 2. What is malformed is told in one sentence, with exit code 2.
#include "cut_sets.hpp"
#include "formulas.hpp"

const std::set<std::string> kEnds{"success", "failure", "abort"};

class Claims {
 public:
  Claims(const Net& net, const States& states, const Clock& clock) : net_(net), states_(states), clock_(clock), formulas_(net, states, clock), count_(states.markings.size()) {}

  bool proved(const std::string& kind, bool holds, const Json& statement, const Json& evidence) {
    if (kind == "safe" || kind == "confluent") return holds;
    if (kind == "can_always_go_on") return go_on(holds, evidence);
    if (kind == "can_succeed") return can_end(holds, evidence, "success");
    if (kind == "can_fail") return can_end(holds, evidence, "failure");
    if (kind == "can_be_aborted") return can_end(holds, evidence, "abort");
    if (kind == "can_always_end") return always(holds, evidence, kEnds);
    if (kind == "can_always_end_safely") return always(holds, evidence, {"success", "abort"});
    if (kind == "nominal_success") return holds && nominal(statement, numbers(evidence.at("numbers")));
    if (kind == "cut_sets") return holds && cuts(statement, evidence.at("survived"));
    return formulas_.on_states(statement.at("formula"))[0] == holds;
  }

  // What a kind asks for; whatever else makes the file malformed.
  void shape(const std::string& kind, bool holds, const Json& statement, const Json& evidence) const {
    const bool always = kind == "can_always_end" || kind == "can_always_end_safely";
    const bool can = kind == "can_succeed" || kind == "can_fail" || kind == "can_be_aborted";
    std::set<std::string> stated, shown;
    if (kind == "nominal_success") {
      stated = {"fails", "endless", "meant", "repaired"};
      shown = {"numbers"};
    } else if (kind == "cut_sets") {
      stated = {"ends", "hardware", "cuts"};
      shown = {"survived"};
    } else if (kind == "can_always_go_on") {
      if (!holds) shown = {"run"};
    } else if (can) {
      if (holds) shown = {"run"};
    } else if (always) {
      shown = {holds ? "numbers" : "run"};
    } else if (kind != "safe" && kind != "confluent") {
      stated = {"text", "formula"};
    }
    keys(statement, stated, "a statement");
    keys(evidence, shown, "evidence");
    if (shown.count("run")) check_run(evidence.at("run"));
    if (shown.count("numbers")) numbers(evidence.at("numbers"));
    if (stated.count("fails")) for (const auto& key : stated) texts(statement.at(key));
    if (stated.count("cuts")) {
      texts(statement.at("ends"));
      texts(statement.at("hardware"));
      for (const Json& each : list(statement.at("cuts"))) texts(each);
      CutSets::shape_of_survived(evidence.at("survived"));
    }
    if (stated.count("formula")) {
      text(statement.at("text"));
      shape_of_formula(statement.at("formula"), Int(net_.places.size()));
    }
  }

 private:
  void check_run(const Json& run) const { numbers(run); }

  // The state after a run; none where it cannot be followed.
  bool follow(const Numbers& run, std::size_t& state) const {
    for (const Int t : run) {
      const auto& out = states_.edges[state];
      const auto edge = std::find_if(out.begin(), out.end(), [&](const Edge& each) { return each.transition == t; });
      if (edge == out.end()) return false;
      state = edge->to;
    }
    return true;
  }
  bool go_on(bool holds, const Json& evidence) const {
    const Set ended = states_.ending(kEnds);
    const auto stuck = [&](std::size_t s) { return states_.edges[s].empty() && !ended[s]; };
    if (!holds) {
      std::size_t state = 0;
      return follow(numbers(evidence.at("run")), state) && stuck(state);
    }
    for (std::size_t s = 0; s < count_; ++s) if (stuck(s)) return false;
    return true;
  }
  bool can_end(bool holds, const Json& evidence, const std::string& role) const {
    const Set ended = states_.ending({role});
    std::size_t state = 0;
    if (holds) return follow(numbers(evidence.at("run")), state) && ended[state];
    return std::find(ended.begin(), ended.end(), true) == ended.end();
  }
  bool always(bool holds, const Json& evidence, const std::set<std::string>& roles) const {
    const Set ended = states_.ending(roles);
    if (!holds) {
      std::size_t state = 0;
      if (!follow(numbers(evidence.at("run")), state)) return false;
      const Set seen = from({state}, [](const Edge&) { return true; });
      for (std::size_t s = 0; s < count_; ++s) if (seen[s] && ended[s]) return false;
      return true;
    }
    const Numbers falls = numbers(evidence.at("numbers"));
    if (falls.size() != count_) return false;
    for (std::size_t s = 0; s < count_; ++s) {
      if (ended[s]) continue;
      const auto& out = states_.edges[s];
      if (std::none_of(out.begin(), out.end(), [&](const Edge& each) { return falls[each.to] >= 0 && falls[each.to] < falls[s]; })) return false;
    }
    return true;
  }
  template <class May> Set from(std::vector<std::size_t> stack, May may) const {
    Set seen(count_);
    for (const std::size_t s : stack) seen[s] = true;
    while (!stack.empty()) {
      const std::size_t s = stack.back();
      stack.pop_back();
      for (const Edge& edge : states_.edges[s])
        if (may(edge) && !seen[edge.to]) { seen[edge.to] = true; stack.push_back(edge.to); }
    }
    return seen;
  }
  const Texts& event(const Edge& edge) const { return net_.transitions[std::size_t(edge.transition)].event; }
  bool is(const Edge& edge, const std::string& what, const std::set<std::string>& of) const {
    return event(edge)[0] == what && of.count(event(edge)[1]) > 0;
  }

  bool nominal(const Json& statement, const Numbers& falls) const {
    if (falls.size() != count_) return false;
    const auto names = [&](const char* key) { const Texts all = texts(statement.at(key)); return std::set<std::string>(all.begin(), all.end()); };
    const std::set<std::string> fails = names("fails"), endless = names("endless"), meant = names("meant"), repaired = names("repaired");
    const auto is_nominal = [&](const Edge& edge) {
      const Texts& what = event(edge);
      if (what[0] == "start") return true;
      if (what[0] == "success") return fails.count(what[1]) == 0;
      return what[0] == "failure" && fails.count(what[1]) > 0;
    };
    const Set mended = from({0}, [&](const Edge& edge) { return is(edge, "repaired", repaired); });
    std::vector<std::size_t> starts;
    for (std::size_t s = 0; s < count_; ++s)
      if (mended[s] && std::none_of(repaired.begin(), repaired.end(), [&](const std::string& name) { return states_.says(s, "oos", name); })) starts.push_back(s);
    if (starts.empty()) return false;
    const Set reached = from(starts, is_nominal);
    const Set succeeded = states_.ending({"success"});
    const auto exempt = [&](std::size_t s) {
      return succeeded[s] || std::any_of(endless.begin(), endless.end(), [&](const std::string& name) { return states_.says(s, "objective", name); });
    };
    std::set<std::string> missing = meant;
    for (std::size_t s = 0; s < count_; ++s) {
      if (falls[s] < 0) return false;
      if (!reached[s]) continue;
      bool goes_on = succeeded[s];
      for (const Edge& edge : states_.edges[s]) {
        if (!is_nominal(edge)) continue;
        goes_on = true;
        if (!exempt(s) && !exempt(edge.to) && falls[edge.to] >= falls[s]) return false;
      }
      if (!goes_on) return false;
      for (const std::string& name : meant) if (states_.says(s, "objective", name)) missing.erase(name);
    }
    return missing.empty();
  }

  bool cuts(const Json& statement, const Json& survived) const {
    const Texts given = texts(statement.at("ends"));
    const Search search{states_.ending({"begin"}), states_.ending({given.begin(), given.end()}), [](std::size_t, const Edge&) { return true; }};
    return CutSets(net_, states_, clock_).proved(statement, survived, search);
  }

  const Net& net_;
  const States& states_;
  const Clock& clock_;
  Formulas formulas_;
  std::size_t count_;
};

int checked(const std::string& path, const Clock& clock) {
  const auto files = unzipped(path);
  const Net net = net_of(parsed(files.at("net.json")));
  const Json claims = parsed(files.at("claims.json"));
  keys(claims, {"format", "version", "mission", "claims", "trusted"}, "claims.json");
  header(claims);
  text(claims.at("mission"));
  for (const Json& each : list(claims.at("trusted"))) {
    keys(each, {"key", "sentence", "why"}, "what is trusted");
    for (const auto& [_, value] : each.members) text(value);
  }
  std::set<std::string> once;
  for (const Json& each : list(claims.at("claims"))) {
    keys(each, {"key", "kind", "subject", "holds", "sentence", "statement", "evidence"}, "a claim");
    require(once.insert(text(each.at("key"))).second, "two claims of one key");
    texts(each.at("subject"));
    text(each.at("sentence"));
    text(each.at("kind"));
    truth(each.at("holds"));
    for (const char* key : {"statement", "evidence"}) require(each.at(key).kind == Json::object, "a claim without an object");
  }
  std::unique_ptr<States> states;
  std::unique_ptr<Claims> of;
  std::string broken, why;
  try {
    states = std::make_unique<States>(net, clock);
  } catch (const Unsafe&) {
    broken = "safe";
  } catch (const NotConfluent&) {
    broken = "confluent";
  } catch (const Limit& limit) {
    why = limit.what();
  }
  if (states) {  // else no claim is looked into
    of = std::make_unique<Claims>(net, *states, clock);
    for (const Json& each : claims.at("claims").items)
      of->shape(each.at("kind").string, each.at("holds").truth, each.at("statement"), each.at("evidence"));
  }
  bool refuted = false, open = claims.at("claims").items.empty();
  for (const Json& each : claims.at("claims").items) {
    const std::string& kind = each.at("kind").string;
    std::string verdict = "not checked";
    if (states) {
      try {
        verdict = of->proved(kind, each.at("holds").truth, each.at("statement"), each.at("evidence")) ? "proved" : "refuted";
      } catch (const Limit& limit) {
        why = limit.what();
      }
    } else if (kind == broken) {
      verdict = "refuted";
    }
    refuted = refuted || verdict == "refuted";
    open = open || verdict == "not checked";
    std::cout << verdict << ' ' << each.at("key").string << '\n';
  }
  for (const char* further : {"further.json", "diagrams.json", "sections.json"})  // which it does not read
    if (files.count(further)) {
      open = true;
      std::cout << "not checked " << further << '\n';
    }
  if (!why.empty()) std::cerr << "limit: " << why << '\n';
  return refuted ? 1 : open ? 2 : 0;
}

int main(int count, char** words) { return answered(count, words, "--max-states", checked); }
