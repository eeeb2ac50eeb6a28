// SPDX-License-Identifier: MIT
// What schemas of pipelines and of declarations are made of: values, and objects as the vocabulary has them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "graph/vocabulary.h"
#include "penumbra/node_type.h"

namespace penumbra::schema {

using Schema = nlohmann::ordered_json;

inline constexpr const char* id_pattern = "^[a-z][a-z0-9_]{0,63}$";

Schema use(const std::string& definition);
Schema text(const char* pattern);
Schema words(const std::vector<std::string>& list);
Schema list_of(Schema item, size_t least, size_t most);  // most of 0: as many as one likes
Schema one_or_list(const char* definition);
Schema only_if(Schema condition, Schema then);
Schema is(std::string_view key, Schema value);
Schema described(Schema schema, std::string_view description);

// Values that may stand in any file.
Schema common_definitions(const Domain& domain, bool in_pipeline);
// What a value of the parameter is, as far as the parameter says.
Schema value_of(const Param& param);

// In a declaration every value counts; in a pipeline a member that is null is none; in a patch every value
// may be null besides, and every key may be missing.
enum class File { declaration, pipeline, patch };

class Maker {
  public:
    Maker(const Domain& domain, File file);

    Schema object(const Object& object, const Scope& scope = {}) const;
    // An object of no other keys. A null for one that does not exist removes nothing.
    Schema closed(Schema properties, const std::vector<std::string>& required = {}) const;
    Schema nullable(Schema schema, bool null_too) const;
    Schema value(Schema schema) const { return nullable(std::move(schema), patch_); }

    bool patch() const { return patch_; }
    std::string name(std::string_view definition) const { return std::string(definition) + suffix_; }

  private:
    // What a key holds by itself, its words, its object: any of them.
    Schema held(const Key& key) const;
    Schema plain(const Key& key) const;
    static Schema whole(const Key& key);
    Schema members(const Key& key) const;

    const Domain& domain_;
    bool patch_, null_members_;
    std::string suffix_;
};

}  // namespace penumbra::schema
