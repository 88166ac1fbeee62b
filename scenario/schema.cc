#include "scenario/schema.h"

#include <nlohmann/json.hpp>

#include "core/operations/operation_schema.h"
#include "core/table/schema.h"
#include "scenario/description.h"

namespace takt::scenario {

nlohmann::ordered_json scenario_schema() {
  using In = table::SchemaPrinter::In;
  table::SchemaPrinter schema(In::kProgram);
  // These have no tables yet (schemas/by_hand.json).
  schema.leave_out({"captures", "commands", "compliance", "expectation", "goal", "handlers", "motion_steps",
                    "on_cancel", "output_value", "starts", "step", "sub_program", "through"});
  nlohmann::ordered_json whole{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "takt scenario"}};
  whole.update(schema.in(In::kFile, description_table().form({},
                                                             "A cell, the program that it runs, and the expected "
                                                             "results (docs/scenarios.md). Whatever needs the "
                                                             "models (joints, reach, names) is checked by 'takt "
                                                             "validate'.")));
  activity::define_operations(schema);
  whole["definitions"] = schema.definitions();
  return whole;
}

}  // namespace takt::scenario
