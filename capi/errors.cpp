// SPDX-License-Identifier: MIT
// Failures, pipelines' mistakes and everything else that is thrown, as codes with a place and a text.
#include "capi/shared.h"

namespace penumbra::c {
namespace {

template <size_t n>
void copy_text(char (&to)[n], const std::string& from) {
    const size_t length = std::min(from.size(), n - 1);
    std::memcpy(to, from.data(), length);
    to[length] = '\0';
}

penumbra_code report(penumbra_error* error, penumbra_code code, VkResult result, const std::string& place,
                     const std::string& text) {
    if (error && error->struct_size >= first_size<penumbra_error>) {
        error->code = code;
        error->result = result;
        copy_text(error->place, place);
        copy_text(error->text, text);
    }
    return code;
}

}  // namespace

[[noreturn]] void misuse(std::string place, std::string text) {
    throw Failure({ErrorCode::usage, std::move(place), std::move(text), VK_SUCCESS});
}

penumbra_code succeeded(penumbra_error* error) noexcept {
    if (error && error->struct_size >= first_size<penumbra_error>) {
        error->code = PENUMBRA_OK;
        error->result = VK_SUCCESS;
        error->place[0] = error->text[0] = '\0';
    }
    return PENUMBRA_OK;
}

namespace {

// Texts take memory, which may be what is missing.
penumbra_code described(penumbra_error* error) {
    try {
        throw;
    } catch (const Failure& failure) {
        const Error& e = failure.error();
        return report(error, static_cast<penumbra_code>(e.code), e.result, e.place, e.text);
    } catch (const Mistakes& mistakes) {
        const Diagnostic& first = mistakes.diagnostics.list().front();
        return report(error, PENUMBRA_PIPELINE, VK_SUCCESS, to_string(first.place),
                      mistakes.diagnostics.text());
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        return report(error, PENUMBRA_INTERNAL, VK_SUCCESS, "", e.what());
    } catch (...) {
        return report(error, PENUMBRA_INTERNAL, VK_SUCCESS, "", "something that is no exception was thrown");
    }
}

}  // namespace

penumbra_code describe(penumbra_error* error) noexcept {
    try {
        return described(error);
    } catch (const std::bad_alloc&) {
        if (error && error->struct_size >= first_size<penumbra_error>) {
            error->code = PENUMBRA_OUT_OF_MEMORY;
            error->result = VK_ERROR_OUT_OF_HOST_MEMORY;
            error->place[0] = '\0';
            std::strcpy(error->text, "no memory");
        }
        return PENUMBRA_OUT_OF_MEMORY;
    }
}

}  // namespace penumbra::c
