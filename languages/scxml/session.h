#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "languages/scxml/chart.h"
#include "languages/scxml/model.h"

namespace takt::languages {

class ChartSession;
class ChartSystem;

/// What an <invoke> of a chart asks for.
struct ChartCall {
  std::string type, id;  ///< "takt:pick"; the invokeid
  const ChartInvoke* from = nullptr;
  std::vector<std::pair<std::string, Data>> parameters;
};

/// What a chart is a part of: it sees what happens, runs what it invokes, and knows the sensors. All may be left out.
struct ChartSurroundings {
  std::function<void(const ChartSession&, std::string_view what, const std::string& text)> told = {};
  /// Begins what is not a chart. @return why not; empty: it has begun, and ends with ChartSystem::end_call()
  std::function<std::string(const ChartSession&, const ChartCall&)> begin = {};
  std::function<void(const ChartSession&, const std::string& id)> cancel = {};
  /// Whether a condition over sensors (takt:cond) is true; nothing: not known.
  std::function<std::optional<bool>(const ChartSession&, const ChartTransition&)> sensors = {};
};

/// One run of a chart: the algorithm of SCXML 1.0, appendix D. It is stepped by its system. Thread: one at a time.
class ChartSession {
 public:
  ChartSession(ChartSystem& system, std::shared_ptr<const Chart> chart, std::string id);
  ~ChartSession();
  ChartSession(const ChartSession&) = delete;
  ChartSession& operator=(const ChartSession&) = delete;

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const Chart& chart() const { return *chart_; }
  [[nodiscard]] bool running() const { return running_; }
  /// Ids of the states that are active, in the order of the document.
  [[nodiscard]] std::vector<std::string> configuration() const;
  [[nodiscard]] const std::set<int>& active() const { return configuration_; }
  /// Why it had to end; empty: it did not.
  [[nodiscard]] const std::string& failure() const { return failure_; }
  /// What its last final state left; of a session that is over.
  [[nodiscard]] const Data& result() const { return result_; }
  [[nodiscard]] ChartModel& model() { return *model_; }

  void post(ChartEvent event) { external_.push_back(std::move(event)); }
  void raise(ChartEvent event) { internal_.push_back(std::move(event)); }
  /// Ends it in order: its states are left, what it invoked is cancelled.
  void cancel();

 private:
  friend class ChartSystem;
  using Block = ChartBlock;
  using TransitionList = std::vector<int>;

  struct Parent {
    ChartSession* session = nullptr;
    std::string invoke_id;
  };
  struct Call {
    int state = 0;
    const ChartInvoke* invoke = nullptr;
    std::string id;
    ChartSession* child = nullptr;  ///< null: it is no chart
  };

  void start(const std::map<std::string, Data>& given);
  /// Comes to rest, then takes one event from outside. @return false if nothing was to do
  bool step();
  bool settle();
  void take_external(const ChartEvent& event);
  void end();
  void fail(std::string why);

  // Appendix D.
  [[nodiscard]] TransitionList select(const ChartEvent* event);
  [[nodiscard]] bool is_enabled(const ChartTransition& transition, const ChartEvent* event);
  [[nodiscard]] TransitionList without_conflicts(const TransitionList& enabled) const;
  void microstep(const TransitionList& transitions);
  void exit_states(const TransitionList& transitions);
  void enter_states(const TransitionList& transitions);
  [[nodiscard]] std::set<int> exit_set(const TransitionList& transitions) const;
  [[nodiscard]] std::vector<int> effective_targets(const std::vector<int>& targets) const;
  [[nodiscard]] int domain(const ChartTransition& transition) const;
  [[nodiscard]] int common_ancestor(int first, const std::vector<int>& others) const;
  [[nodiscard]] bool is_in_final(int state) const;
  struct Entry;
  void add_descendants(int state, Entry& entry) const;
  void add_ancestors(int state, int around, Entry& entry) const;
  void add_regions(int state, Entry& entry) const;
  void enter(int state, const Entry& entry);
  void leave(int state);
  void finish(int state);

  // Executable content.
  bool run(const Block& block);
  bool run_action(const ChartAction& action);
  bool run_send(const ChartAction& action);
  bool run_for_each(const ChartAction& action);
  bool run_if(const ChartAction& action);
  bool run_assign(const ChartAction& action);
  [[nodiscard]] std::optional<Data> data_of(const std::vector<ChartParameter>& parameters, const ChartContent& content,
                                            const std::string& names, bool skips_wrong);
  /// The text of an attribute, or what the expression in another one is worth; nothing after an error.
  [[nodiscard]] std::optional<std::string> text_of(const ChartAction& action, std::string_view plain,
                                                   std::string_view expression);
  void initialize(const std::vector<ChartVariable>& variables, const std::map<std::string, Data>* given);
  void invoke(int state, const ChartInvoke& invoke);
  [[nodiscard]] std::optional<std::vector<std::pair<std::string, Data>>> parameters_of(const ChartInvoke& invoke);
  bool begin_child(const ChartInvoke& invoke, Call& call, const std::vector<std::pair<std::string, Data>>& parameters);
  void finalize(const ChartInvoke& invoke, const ChartEvent& event);
  void cancel_call(const Call& call);
  /// error.execution or another error, as an event; a script without an end ends the session. @return false
  bool error(std::string_view name, const std::string& why, const std::string& sendid = {});
  void tell(std::string_view what, const std::string& text) const;

  [[nodiscard]] const ChartState& state(int index) const { return chart_->states[static_cast<std::size_t>(index)]; }
  [[nodiscard]] const ChartTransition& transition(int index) const {
    return chart_->transitions[static_cast<std::size_t>(index)];
  }
  [[nodiscard]] std::vector<int> default_targets(int state) const;

  ChartSystem& system_;
  std::shared_ptr<const Chart> chart_;
  std::string id_;
  Parent parent_;
  std::unique_ptr<ChartModel> model_;
  bool running_ = false, started_ = false;
  std::set<int> configuration_, to_invoke_, initialized_;
  std::map<int, std::vector<int>> history_;
  std::deque<ChartEvent> internal_, external_;
  std::vector<Call> calls_;
  int numbers_ = 0;
  Data result_;
  std::string failure_;
};

}  // namespace takt::languages
