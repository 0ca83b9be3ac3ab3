// Formulas of CTL* on the states of a net: the states in which they are true.
#pragma once

#include "grown.hpp"
#include "listing.hpp"
#include "shapes.hpp"

class Formulas {
 public:
  Formulas(const Net& net, const States& states, const Clock& clock) : net_(net), states_(states), clock_(clock), count_(states.markings.size()), before_(count_) {
    for (std::size_t s = 0; s < count_; ++s) for (const Edge& edge : states.edges[s]) before_[edge.to].push_back(s);
  }

  // What is found once serves every formula that has it as a part.
  const Set& on_states(const Json& of) {
    const std::string key = key_of(of);
    if (const auto known = known_.find(key); known != known_.end()) return known->second;
    Set found = satisfying(of);
    return known_.emplace(key, std::move(found)).first->second;
  }

 private:
  static std::string key_of(const Json& of) {
    if (of.kind == Json::number) return std::to_string(of.value);
    if (of.kind == Json::text) return std::to_string(of.string.size()) + ":" + of.string;
    std::string made = "[";
    for (const Json& each : of.items) made += key_of(each) + " ";
    return made + "]";
  }
  Set satisfying(const Json& of) {
    const auto& parts = of.items;
    const std::string& op = parts[0].string;
    Set found(count_);
    const auto each = [&](auto is) { for (std::size_t s = 0; s < count_; ++s) found[s] = is(s); };
    if (op == "says") {
      found = states_.saying(parts[1].string, parts[2].string);
    } else if (op == "at most") {
      each([&](std::size_t s) {
        Wide sum = 0;
        for (const Json& pair : parts[2].items) if (states_.markings[s][std::size_t(pair.items[0].value)]) sum += pair.items[1].value;
        return sum <= parts[1].value;
      });
    } else if (op == "fires") {
      const std::vector<bool> named = transitions(parts);
      each([&](std::size_t s) { const auto& out = states_.edges[s]; return std::any_of(out.begin(), out.end(), [&](const Edge& edge) { return bool(named[std::size_t(edge.transition)]); }); });
    } else if (op == "deadlock") {
      each([&](std::size_t s) { return states_.edges[s].empty(); });
    } else if (op == "not") {
      found = on_states(parts[1]);
      found.flip();
    } else if (op == "and" || op == "or") {
      const bool all = op == "and";
      found.assign(count_, all);
      for (std::size_t i = 1; i < parts.size(); ++i) {
        const Set& part = on_states(parts[i]);
        each([&](std::size_t s) { return all ? found[s] && part[s] : found[s] || part[s]; });
      }
    } else if (op == "EX") {
      const Set& next = on_states(parts[1]);
      each([&](std::size_t s) { const auto& out = states_.edges[s]; return std::any_of(out.begin(), out.end(), [&](const Edge& edge) { return bool(next[edge.to]); }); });
    } else if (op == "EU") {
      const Set& through = on_states(parts[1]);
      found = grown(on_states(parts[2]), [&](std::size_t s, const auto& add) { for (const std::size_t from : before_[s]) if (through[from]) add(from); });
    } else if (op == "EG") {
      found = on_states(parts[1]);
      for (bool changed = true; changed;) {
        changed = false;
        clock_.look(0);
        for (std::size_t s = 0; s < count_; ++s) {
          const auto& out = states_.edges[s];
          if (found[s] && !out.empty() && std::none_of(out.begin(), out.end(), [&](const Edge& edge) { return bool(found[edge.to]); })) {
            found[s] = false;
            changed = true;
          }
        }
      }
    } else {
      found = some_path(parts[1]);
    }
    return found;
  }

  // The transitions whose events a part of a formula names.
  std::vector<bool> transitions(const std::vector<Json>& parts) const {
    std::set<Texts> named;
    for (std::size_t i = 1; i < parts.size(); ++i) named.insert(texts(parts[i]));
    std::vector<bool> found;
    for (const Transition& each : net_.transitions) found.push_back(named.count(each.event) > 0);
    return found;
  }

  // Nodes are a state, the step that is taken there, and what is promised of the next node.
  struct Part { enum Op { state, happens, negation, all, any, next, until } op; std::vector<bool> set; std::vector<std::size_t> parts; int promise = -1; };  // a set of states, or of transitions that happen
  std::size_t part_of(const Json& of, std::vector<Part>& parts, int& promises) {
    const std::string& op = of.items[0].string;
    Part made{Part::state, {}, {}, -1};
    const auto inner = [&](std::size_t i) { return part_of(of.items[i], parts, promises); };
    const auto add = [&](Part part) { parts.push_back(std::move(part)); return parts.size() - 1; };
    const auto negated = [&](std::size_t part) { return add({Part::negation, {}, {part}, -1}); };
    if (op == "happens") { made.op = Part::happens; made.set = transitions(of.items); }
    else if (op == "not") { made.op = Part::negation; made.parts = {inner(1)}; }
    else if (op == "and" || op == "or") {
      made.op = op == "and" ? Part::all : Part::any;
      for (std::size_t i = 1; i < of.items.size(); ++i) made.parts.push_back(inner(i));
    } else if (op == "X") { made.op = Part::next; made.parts = {inner(1)}; made.promise = promises++; }
    else if (op == "U") { made.op = Part::until; made.parts = {inner(1), inner(2)}; made.promise = promises++; }
    else if (op == "R") {
      const std::size_t first = negated(inner(1)), second = negated(inner(2));
      return negated(add({Part::until, {}, {first, second}, promises++}));
    } else made.set = on_states(of);
    return add(std::move(made));
  }
  Set some_path(const Json& formula) {
    std::vector<Part> parts;
    int promises = 0;
    const std::size_t top = part_of(formula, parts, promises);
    if (promises > 16) throw Limit("a formula on paths with more than 16 promises");
    const std::size_t kinds = std::size_t(1) << promises;
    // Nodes: for each state its steps, one that repeats where there is none; for each step the promises.
    std::vector<std::size_t> first{0};
    for (std::size_t s = 0; s < count_; ++s) first.push_back(first.back() + std::max<std::size_t>(1, states_.edges[s].size()));
    const std::size_t count = first.back() * kinds;
    if (count > (std::size_t(1) << 26)) throw Limit("too many nodes beside a formula on paths");
    clock_.look(0);
    std::vector<std::vector<bool>> holds(parts.size(), std::vector<bool>(count));
    for (std::size_t s = 0; s < count_; ++s) {
      for (std::size_t step = first[s]; step < first[s + 1]; ++step) {
        for (std::size_t kind = 0; kind < kinds; ++kind) {
          const std::size_t node = step * kinds + kind;
          for (std::size_t i = 0; i < parts.size(); ++i) {
            const Part& part = parts[i];
            const auto inner = [&](std::size_t which) { return bool(holds[part.parts[which]][node]); };
            bool is = false;
            switch (part.op) {
              case Part::state: is = part.set[s]; break;
              case Part::happens: is = !states_.edges[s].empty() && part.set[std::size_t(states_.edges[s][step - first[s]].transition)]; break;
              case Part::negation: is = !inner(0); break;
              case Part::all: is = true; for (std::size_t k = 0; k < part.parts.size(); ++k) is = is && inner(k); break;
              case Part::any: for (std::size_t k = 0; k < part.parts.size(); ++k) is = is || inner(k); break;
              case Part::next: is = kind >> part.promise & 1; break;
              case Part::until: is = inner(1) || (inner(0) && (kind >> part.promise & 1)); break;
            }
            holds[i][node] = is;
          }
        }
      }
    }
    std::vector<std::size_t> state_of;  // by step
    for (std::size_t s = 0; s < count_; ++s) state_of.resize(first[s + 1], s);
    if (!promises) {  // whatever the first step is, some maximal path goes on behind it
      Set found(count_);
      for (std::size_t step = 0; step < count; ++step) if (holds[top][step]) found[state_of[step]] = true;
      return found;
    }
    // What is promised of a node: the part behind an X, an until itself.
    std::vector<std::uint32_t> promised(count);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts[i].promise < 0) continue;
      const auto& kept = holds[parts[i].op == Part::next ? parts[i].parts[0] : i];
      for (std::size_t node = 0; node < count; ++node) if (kept[node]) promised[node] |= std::uint32_t(1) << parts[i].promise;
    }
    // Vertices are a state and what is promised of a path from there; nodes that keep this promise are their edges.
    Graph graph{kinds, first, promised, {}};
    for (std::size_t step = 0; step < first.back(); ++step) {
      const auto& out = states_.edges[state_of[step]];
      graph.to.push_back(out.empty() ? state_of[step] : out[step - first[state_of[step]]].to);
    }
    std::vector<std::size_t> roots;
    for (std::size_t node = 0; node < count; ++node) if (holds[top][node]) roots.push_back(graph.after(node));
    const auto is_kept = [&](std::size_t part, std::size_t node) { return !holds[part][node] || holds[parts[part].parts[1]][node]; };
    std::vector<std::size_t> untils;
    for (std::size_t i = 0; i < parts.size(); ++i) if (parts[i].op == Part::until) untils.push_back(i);
    const std::vector<bool> good = keeping(graph, roots, untils, is_kept);
    Set found(count_);
    for (std::size_t node = 0; node < count; ++node) if (holds[top][node] && good[graph.after(node)]) found[state_of[node / kinds]] = true;
    return found;
  }

  struct Graph {
    std::size_t kinds;
    std::vector<std::size_t> first;  // steps by state
    std::vector<std::uint32_t> promised;  // by node
    std::vector<std::size_t> to;  // by step
    std::size_t after(std::size_t node) const { return to[node / kinds] * kinds + node % kinds; }
    // The first node from one on that is an edge of a vertex; the end of these nodes where there is none.
    std::size_t edge(std::size_t vertex, std::size_t from) const {
      while (from < end(vertex) && promised[from] != vertex % kinds) ++from;
      return from;
    }
    std::size_t begin(std::size_t vertex) const { return edge(vertex, first[vertex / kinds] * kinds); }
    std::size_t end(std::size_t vertex) const { return first[vertex / kinds + 1] * kinds; }
  };
  // The vertices, of those that some lead to, that lead to a strongly connected component in which no until is put off for ever (Tarjan).
  template <class IsKept>
  std::vector<bool> keeping(const Graph& graph, const std::vector<std::size_t>& roots, const std::vector<std::size_t>& untils, const IsKept& is_kept) const {
    const std::size_t count = count_ * graph.kinds;
    std::vector<std::size_t> index(count), low(count), stack;
    std::vector<bool> on_stack(count), good(count);
    std::size_t counter = 0;
    struct Frame { std::size_t vertex, edge; };
    std::vector<Frame> frames;
    const auto enter = [&](std::size_t vertex) {
      index[vertex] = low[vertex] = ++counter;
      stack.push_back(vertex);
      on_stack[vertex] = true;
      frames.push_back({vertex, graph.begin(vertex)});
      if (counter % 4096 == 0) clock_.look(0);
    };
    const auto judge = [&](const std::vector<std::size_t>& members) {
      bool turns = false, reaches = false;
      std::set<std::size_t> open(untils.begin(), untils.end());
      const std::set<std::size_t> inside(members.begin(), members.end());
      for (const std::size_t member : members)
        for (std::size_t edge = graph.begin(member); edge < graph.end(member); edge = graph.edge(member, edge + 1)) {
          reaches = reaches || good[graph.after(edge)];
          if (!inside.count(graph.after(edge))) continue;
          turns = true;
          for (auto until = open.begin(); until != open.end();) until = is_kept(*until, edge) ? open.erase(until) : std::next(until);
        }
      for (const std::size_t member : members) good[member] = reaches || (turns && open.empty());
    };
    for (const std::size_t root : roots) {
      if (index[root]) continue;
      enter(root);
      while (!frames.empty()) {
        const auto [vertex, edge] = frames.back();
        if (edge < graph.end(vertex)) {
          frames.back().edge = graph.edge(vertex, edge + 1);
          const std::size_t next = graph.after(edge);
          if (!index[next]) enter(next);
          else if (on_stack[next]) low[vertex] = std::min(low[vertex], index[next]);
          continue;
        }
        if (low[vertex] == index[vertex]) {
          const auto from = std::find(stack.rbegin(), stack.rend(), vertex).base() - 1;
          const std::vector<std::size_t> members(from, stack.end());
          stack.erase(from, stack.end());
          for (const std::size_t member : members) on_stack[member] = false;
          judge(members);
        }
        frames.pop_back();
        if (!frames.empty()) low[frames.back().vertex] = std::min(low[frames.back().vertex], low[vertex]);
      }
    }
    return good;
  }

  const Net& net_;
  const States& states_;
  const Clock& clock_;
  std::size_t count_;
  std::vector<std::vector<std::size_t>> before_;  // by state, those with an edge to it
  std::map<std::string, Set> known_;
};
