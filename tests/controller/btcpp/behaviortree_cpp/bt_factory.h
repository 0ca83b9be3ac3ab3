// A stand-in for BehaviorTree.CPP 4: what the generated node and the tests use of it, with the same signatures.
// Trees have sequences, reactive sequences and registered nodes; the rest of XML is not read.
#ifndef BT_STAND_IN
#define BT_STAND_IN

#include <any>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

namespace BT {

using StringView = std::string_view;

enum class NodeStatus { IDLE = 0, RUNNING = 1, SUCCESS = 2, FAILURE = 3, SKIPPED = 4 };
enum class NodeType { UNDEFINED = 0, ACTION, CONDITION, CONTROL, DECORATOR, SUBTREE };

inline std::string toStr(NodeStatus status)
{
    static const char *const names[] = {"IDLE", "RUNNING", "SUCCESS", "FAILURE", "SKIPPED"};
    return names[static_cast<int>(status)];
}

class RuntimeError : public std::runtime_error {
public:
    template <typename... Texts> explicit RuntimeError(const Texts &...texts) : std::runtime_error(joined(texts...)) {}

private:
    template <typename... Texts> static std::string joined(const Texts &...texts)
    {
        std::string found;
        (found.append(std::string(texts)), ...);
        return found;
    }
};

// std::expected, as far as it is asked.
struct Error {
    std::string text;
};
class Result {
public:
    Result() = default;
    Result(Error error) : error_(std::move(error)) {}
    explicit operator bool() const { return !error_; }
    bool has_value() const { return !error_; }

private:
    std::optional<Error> error_;
};

class Blackboard {
public:
    using Ptr = std::shared_ptr<Blackboard>;
    static Ptr create() { return std::make_shared<Blackboard>(); }
    template <typename T> void set(const std::string &key, const T &value) { values_[key] = value; }
    template <typename T> bool get(const std::string &key, T &value) const
    {
        const auto found = values_.find(key);
        if (found == values_.end()) {
            return false;
        }
        value = std::any_cast<T>(found->second);
        return true;
    }

private:
    std::map<std::string, std::any> values_;
};

enum class PortDirection { INPUT, OUTPUT, INOUT };
struct PortInfo {
    PortDirection direction;
    std::string description;
};
using PortsList = std::unordered_map<std::string, PortInfo>;
using PortsRemapping = std::unordered_map<std::string, std::string>;

inline std::pair<std::string, PortInfo> port(PortDirection direction, StringView name, StringView words)
{
    return {std::string(name), PortInfo{direction, std::string(words)}};
}
template <typename T> std::pair<std::string, PortInfo> InputPort(StringView name, StringView words = {})
{
    return port(PortDirection::INPUT, name, words);
}
template <typename T> std::pair<std::string, PortInfo> OutputPort(StringView name, StringView words = {})
{
    return port(PortDirection::OUTPUT, name, words);
}
template <typename T> std::pair<std::string, PortInfo> BidirectionalPort(StringView name, StringView words = {})
{
    return port(PortDirection::INOUT, name, words);
}

struct TreeNodeManifest {
    NodeType type;
    std::string registration_ID;
    PortsList ports;
};
struct NodeConfig {
    Blackboard::Ptr blackboard;
    PortsRemapping input_ports;
    PortsRemapping output_ports;
    const TreeNodeManifest *manifest = nullptr;
    std::function<void()> wake;
};

class TreeNode {
public:
    TreeNode(std::string name, NodeConfig config) : name_(std::move(name)), config_(std::move(config)) {}
    TreeNode(const TreeNode &) = delete;
    TreeNode &operator=(const TreeNode &) = delete;
    virtual ~TreeNode() = default;

    virtual NodeStatus executeTick()
    {
        status_ = tick();
        return status_;
    }
    virtual void halt() = 0;
    void haltNode() { halt(); }
    NodeStatus status() const { return status_; }
    const std::string &name() const { return name_; }
    const NodeConfig &config() const { return config_; }
    void resetStatus() { status_ = NodeStatus::IDLE; }
    void emitWakeUpSignal()
    {
        if (config_.wake) {
            config_.wake();
        }
    }

    template <typename T> Result getInput(const std::string &key, T &destination) const
    {
        const auto found = config_.input_ports.find(key);
        if (found == config_.input_ports.end()) {
            return Error{"no such port"};
        }
        if (const auto entry = pointed(found->second)) {
            return config_.blackboard->get(*entry, destination) ? Result() : Result(Error{"no such entry"});
        }
        if constexpr (std::is_same_v<T, bool>) {
            destination = found->second == "true";
        } else {
            destination = found->second;
        }
        return {};
    }

    template <typename T> Result setOutput(const std::string &key, const T &value)
    {
        const auto found = config_.output_ports.find(key);
        const auto entry = found == config_.output_ports.end() ? std::nullopt : pointed(found->second);
        if (!entry) {
            return Error{"no entry of the blackboard"};
        }
        if constexpr (std::is_convertible_v<T, std::string>) {
            config_.blackboard->set(*entry, std::string(value));
        } else {
            config_.blackboard->set(*entry, value);
        }
        return {};
    }

protected:
    virtual NodeStatus tick() = 0;
    void setStatus(NodeStatus status) { status_ = status; }

private:
    static std::optional<std::string> pointed(const std::string &text)
    {
        const bool braces = text.size() > 2U && text.front() == '{' && text.back() == '}';
        return braces ? std::optional(text.substr(1U, text.size() - 2U)) : std::nullopt;
    }

    std::string name_;
    NodeConfig config_;
    NodeStatus status_ = NodeStatus::IDLE;
};

class StatefulActionNode : public TreeNode {
public:
    StatefulActionNode(const std::string &name, const NodeConfig &config) : TreeNode(name, config) {}
    virtual NodeStatus onStart() = 0;
    virtual NodeStatus onRunning() = 0;
    virtual void onHalted() = 0;

protected:
    NodeStatus tick() override final
    {
        if (status() == NodeStatus::IDLE) {
            const NodeStatus found = onStart();
            if (found == NodeStatus::IDLE) {
                throw RuntimeError("onStart() must not return IDLE");
            }
            return found;
        }
        return status() == NodeStatus::RUNNING ? onRunning() : status();
    }
    void halt() override final
    {
        if (status() == NodeStatus::RUNNING) {
            onHalted();
        }
        resetStatus();
    }
};

class ConditionNode : public TreeNode {
public:
    ConditionNode(const std::string &name, const NodeConfig &config) : TreeNode(name, config) {}
    void halt() override final { resetStatus(); }
};

class ControlNode : public TreeNode {
public:
    ControlNode(bool reactive, NodeConfig config) : TreeNode("", std::move(config)), reactive_(reactive) {}
    std::vector<std::unique_ptr<TreeNode>> children;
    void halt() override
    {
        for (const auto &child : children) {
            child->haltNode();
        }
        at_ = 0U;
        resetStatus();
    }

private:
    NodeStatus tick() override
    {
        for (std::size_t i = reactive_ ? 0U : at_; i < children.size(); i++) {
            const NodeStatus found = children[i]->executeTick();
            if (found == NodeStatus::SUCCESS) {
                continue;
            }
            for (std::size_t j = 0U; reactive_ && j < children.size(); j++) {
                if (j != i) {
                    children[j]->haltNode();
                }
            }
            at_ = i;
            if (found != NodeStatus::RUNNING) {
                halt();
            }
            return found;
        }
        halt();
        return NodeStatus::SUCCESS;
    }
    bool reactive_;
    std::size_t at_ = 0U;
};

class Tree {
public:
    Tree(Blackboard::Ptr blackboard, std::shared_ptr<bool> woken, std::unique_ptr<TreeNode> root)
        : blackboard_(std::move(blackboard)), woken_(std::move(woken)), root_(std::move(root))
    {}
    NodeStatus tickExactlyOnce()
    {
        *woken_ = false;
        const NodeStatus found = root_->executeTick();
        if (found == NodeStatus::SUCCESS || found == NodeStatus::FAILURE) {
            root_->resetStatus();
        }
        return found;
    }
    NodeStatus tickOnce()
    {
        NodeStatus found = tickExactlyOnce();
        while (found == NodeStatus::RUNNING && *woken_) { // a tick that is asked for meanwhile comes at once
            found = tickExactlyOnce();
        }
        return found;
    }
    void haltTree() { root_->haltNode(); }
    TreeNode *rootNode() const { return root_.get(); }
    Blackboard::Ptr rootBlackboard() { return blackboard_; }

private:
    Blackboard::Ptr blackboard_;
    std::shared_ptr<bool> woken_;
    std::unique_ptr<TreeNode> root_;
};

class BehaviorTreeFactory {
public:
    template <typename T, typename... Extra> void registerNodeType(const std::string &id, Extra... extra)
    {
        static_assert(std::is_constructible_v<T, const std::string &, const NodeConfig &, Extra...>);
        manifests_[id] = TreeNodeManifest{NodeType::UNDEFINED, id, T::providedPorts()};
        builders_[id] = [extra...](const std::string &name, const NodeConfig &config) -> std::unique_ptr<TreeNode> {
            return std::make_unique<T>(name, config, extra...);
        };
    }

    Tree createTreeFromText(const std::string &text)
    {
        auto blackboard = Blackboard::create();
        auto woken = std::make_shared<bool>(false);
        std::size_t at = text.find("<BehaviorTree");
        at = text.find('>', at) + 1U;
        auto root = node(text, at, blackboard, woken);
        return Tree(blackboard, woken, std::move(root));
    }

private:
    std::unique_ptr<TreeNode> node(const std::string &text, std::size_t &at, const Blackboard::Ptr &blackboard,
        const std::shared_ptr<bool> &woken)
    {
        const std::size_t end = text.find('>', at = text.find('<', at));
        const bool empty = text[end - 1U] == '/';
        const std::string tag = text.substr(at + 1U, end - at - (empty ? 2U : 1U));
        at = end + 1U;
        const std::string id = tag.substr(0U, tag.find(' '));
        NodeConfig config;
        config.blackboard = blackboard;
        config.wake = [woken] { *woken = true; };
        if (id == "Sequence" || id == "ReactiveSequence") {
            auto made = std::make_unique<ControlNode>(id == "ReactiveSequence", config);
            while (text.compare(text.find('<', at), 2U, "</") != 0) {
                made->children.push_back(node(text, at, blackboard, woken));
            }
            at = text.find('>', at) + 1U;
            return made;
        }
        config.manifest = &manifests_.at(id);
        for (std::size_t from = tag.find(' '); from != std::string::npos;) {
            const std::size_t equals = tag.find('=', from), close = tag.find('"', equals + 2U);
            const std::string key = tag.substr(from + 1U, equals - from - 1U);
            const std::string value = tag.substr(equals + 2U, close - equals - 2U);
            from = tag.find(' ', close);
            const PortDirection direction = config.manifest->ports.at(key).direction;
            if (direction != PortDirection::OUTPUT) {
                config.input_ports[key] = value;
            }
            if (direction != PortDirection::INPUT) {
                config.output_ports[key] = value;
            }
        }
        return builders_.at(id)(id, config);
    }

    std::map<std::string, TreeNodeManifest> manifests_;
    std::map<std::string, std::function<std::unique_ptr<TreeNode>(const std::string &, const NodeConfig &)>> builders_;
};

} // namespace BT

#endif
