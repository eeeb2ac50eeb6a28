// SPDX-License-Identifier: MIT
// An entry: a line that names the format, a checksum of the rest, then length-prefixed texts and the SPIR-V.
// Numbers are 64 bits in the machine's byte order, which the checksum makes safe. Written beside its name and
// renamed: a reader sees a whole entry or none.
#include "graph/shader_cache.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <fstream>

#include "graph/fnv1a.h"
#include "graph/read_text.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view magic = "penumbra shader 1\n";

void put(std::string& out, uint64_t number) {
    char bytes[sizeof number];
    std::memcpy(bytes, &number, sizeof number);
    out.append(bytes, sizeof number);
}

void put(std::string& out, std::string_view text) {
    put(out, uint64_t{text.size()});
    out += text;
}

// Reads what put() wrote; once anything is missing, everything after it is empty.
class Cursor {
  public:
    explicit Cursor(std::string_view bytes) : bytes_(bytes) {}

    uint64_t number() {
        const std::string_view taken = take(sizeof(uint64_t));
        uint64_t value = 0;
        if (!taken.empty()) std::memcpy(&value, taken.data(), sizeof value);
        return value;
    }
    std::string_view text() { return take(number()); }
    std::string_view rest() const { return bytes_; }
    bool good() const { return good_; }

  private:
    std::string_view take(uint64_t size) {
        good_ = good_ && size <= bytes_.size();
        if (!good_) return {};
        const std::string_view taken = bytes_.substr(0, size);
        bytes_.remove_prefix(size);
        return taken;
    }

    std::string_view bytes_;
    bool good_ = true;
};

// What the shader was compiled from, without the included texts.
std::string inputs_of(const std::string& compiler, const ShaderSource& source) {
    std::string bytes;
    put(bytes, compiler);
    put(bytes, source.node_glsl);
    put(bytes, *source.text);
    return bytes;
}

std::string temporary_name(const fs::path& entry) {
    static std::atomic<uint32_t> count{0};
    return fmt::format("{}.{}.{}", entry.string(), getpid(), count++);
}

}  // namespace

ShaderCache::ShaderCache(fs::path folder, Warn warn)
    : folder_(std::move(folder)), warn_(std::move(warn)), compiler_(shader_compiler_version()) {}

ShaderCache::Counts ShaderCache::counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
}

void ShaderCache::warn(const std::string& message) {
    if (warn_) warn_(message);
}

std::optional<CompiledShader> ShaderCache::compile(ShaderSource source, const std::string& variant,
                                                   Diagnostics& diagnostics) {
    if (!source.text) source.text = read_text(source.file);
    const fs::path entry = folder_.empty() || !source.text ? fs::path() : entry_file(source, variant);
    if (!entry.empty())
        if (auto found = find(entry, source)) {
            const std::lock_guard lock(mutex_);
            ++counts_.found;
            return found;
        }
    auto shader = compile_shader(source, diagnostics);
    {
        const std::lock_guard lock(mutex_);
        ++counts_.compiled;
    }
    if (shader && !entry.empty()) keep(entry, source, *shader);
    return shader;
}

fs::path ShaderCache::entry_file(const ShaderSource& source, const std::string& variant) const {
    std::error_code error;
    const fs::path absolute = fs::weakly_canonical(source.file, error);
    std::string name;
    put(name, (error ? source.file : absolute).string());
    put(name, variant);
    return folder_ / fmt::format("{}-{:016x}.spv-cache", source.file.stem().string(), fnv1a(name));
}

std::optional<CompiledShader> ShaderCache::find(const fs::path& entry, const ShaderSource& source) {
    const std::optional<std::string> bytes = read_text(entry);
    if (!bytes) return std::nullopt;
    const auto corrupt = [&]() -> std::optional<CompiledShader> {
        const std::lock_guard lock(mutex_);
        ++counts_.corrupt;
        warn(fmt::format("{}: damaged; compiling {} again", entry.string(), source.file.string()));
        return std::nullopt;
    };
    if (!bytes->starts_with(magic)) return corrupt();
    Cursor cursor(std::string_view(*bytes).substr(magic.size()));
    const uint64_t checksum = cursor.number();
    if (!cursor.good() || checksum != fnv1a(cursor.rest())) return corrupt();

    // From here on the entry is as it was written, and it may well be out of date.
    const std::string inputs = inputs_of(compiler_, source);
    if (!cursor.rest().starts_with(inputs)) return std::nullopt;
    cursor = Cursor(cursor.rest().substr(inputs.size()));
    CompiledShader shader;
    for (uint64_t left = cursor.number(); left > 0 && cursor.good(); --left) {
        const std::string name(cursor.text());
        const std::string_view text = cursor.text();
        const auto now = resolve_include(source, name);
        if (!now || now->text != text) return std::nullopt;
        if (!now->embedded) shader.dependencies.push_back(now->name);
    }
    const std::string_view code = cursor.text();
    if (!cursor.good() || !cursor.rest().empty() || code.empty() || code.size() % 4 != 0) return corrupt();
    shader.spirv.resize(code.size() / 4);
    std::memcpy(shader.spirv.data(), code.data(), code.size());
    if (!is_valid_spirv(shader.spirv)) return corrupt();
    return shader;
}

void ShaderCache::keep(const fs::path& entry, const ShaderSource& source, const CompiledShader& shader) {
    std::string body = inputs_of(compiler_, source);
    put(body, uint64_t{shader.includes.size()});
    for (const auto& [name, text] : shader.includes) {
        put(body, name);
        put(body, text);
    }
    put(body, std::string_view(reinterpret_cast<const char*>(shader.spirv.data()), 4 * shader.spirv.size()));

    std::error_code error;
    fs::create_directories(folder_, error);
    const fs::path temporary = temporary_name(entry);
    std::ofstream file(temporary, std::ios::binary);
    std::string head(magic);
    put(head, fnv1a(body));
    file << head << body;
    file.close();
    if (file) fs::rename(temporary, entry, error);
    if (file && !error) return;
    fs::remove(temporary, error);
    const std::lock_guard lock(mutex_);
    if (!unwritable_)
        warn(fmt::format("{}: cannot be written; shaders are compiled anew each time", folder_.string()));
    unwritable_ = true;
}

}  // namespace penumbra
