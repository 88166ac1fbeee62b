// Values as a file would have them.
#include <utility>

#include <nlohmann/json.hpp>

#include "core/table/field.h"
#include "core/table/schema.h"

namespace takt::table {

Writer::Writer() : json_(std::make_unique<nlohmann::ordered_json>(nlohmann::ordered_json::object())) {}
Writer::~Writer() = default;
void Writer::number(const std::string& key, double value) { (*json_)[key] = plain_number(value); }
void Writer::integer(const std::string& key, std::int64_t value) { (*json_)[key] = value; }
void Writer::boolean(const std::string& key, bool value) { (*json_)[key] = value; }
void Writer::text(const std::string& key, const std::string& value) { (*json_)[key] = value; }
void Writer::texts(const std::string& key, const std::vector<std::string>& values) { (*json_)[key] = values; }
void Writer::vector(const std::string& key, const Eigen::Vector3d& value) {
  (*json_)[key] = {value.x(), value.y(), value.z()};
}
void Writer::object(const std::string& key, const Writer& members) { (*json_)[key] = members.result(); }
void Writer::json(const std::string& key, nlohmann::ordered_json value) { (*json_)[key] = std::move(value); }

}  // namespace takt::table
