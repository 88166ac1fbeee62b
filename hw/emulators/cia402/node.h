#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "hw/emulators/cia402/drive.h"

namespace takt::hw::cia402 {

/// A CANopen node with a drive in it: network management, heartbeats in both directions, a server of service data,
/// process data by mapping parameters, emergencies. Strict: what a real node refuses is refused. One thread.
/// Realtime: cyclic but for the constructor.
class Node {
 public:
  using Send = std::function<void(const CanFrame&)>;

  /// @param id  of the node, 1 to 126
  Node(NodeId id, const DriveOptions& options, Send send);
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// A frame of the bus, whomever it is for.
  void take(const CanFrame& frame, Nanoseconds now);
  /// Time goes on: heartbeats, stops of the drive by itself.
  void pass(Nanoseconds now);
  /// While its joint cannot be measured, cycles of the bus pass it by.
  void set_measurable(bool measurable) { measurable_ = measurable; }
  /// Switched off and on.
  void restart(Nanoseconds now);

  /// As of Drive; also of one that was switched off in motion with its node.
  [[nodiscard]] bool take_brakes() { return std::exchange(brakes_, false) || drive_->take_brakes(); }
  [[nodiscard]] Drive& drive() { return *drive_; }
  [[nodiscard]] NmtState state() const { return state_; }
  [[nodiscard]] Dictionary& objects() { return objects_; }

 private:
  void fill_dictionary();
  void fill_communication();
  void obey(NmtCommand command, Nanoseconds now);
  void leave_operation(NmtState state, Nanoseconds now);
  void hear_heartbeat(const CanFrame& frame, Nanoseconds now);
  void watch_master(Nanoseconds now);
  void serve(const SdoMessage& request);
  [[nodiscard]] std::optional<SdoAbort> refuse(const SdoMessage& request) const;
  [[nodiscard]] std::optional<SdoAbort> refuse_mapping(const SdoMessage& request) const;
  void begin_cycle(Nanoseconds now);
  void take_outputs(const CanFrame& frame);
  void send_inputs(std::uint16_t number);
  void send_errors();

  NodeId id_;
  DriveOptions options_;
  Send send_;
  Dictionary objects_;
  std::unique_ptr<Drive> drive_;
  NmtState state_ = NmtState::kBootUp;
  bool measurable_ = false, brakes_ = false;
  unsigned used_ = 0, came_ = 0;  // messages with outputs that this master sends; of these, since SYNC
  bool targeted_ = false;         // one of the latter had the target
  Nanoseconds next_heartbeat_ = 0, master_heard_ = -1;
};

}  // namespace takt::hw::cia402
