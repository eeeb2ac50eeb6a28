// SPDX-License-Identifier: MIT
// Preloaded: of the calls that put a file on the disk, the one whose number PENUMBRA_FAIL_FILE_AT says goes
// wrong as PENUMBRA_FAIL_FILE_HOW says: "short" writes a part, "kill" ends the process there, a number is the
// errno that it fails with. Says on the standard error stream which call it was; streams themselves are left
// alone. Only calls below the folder PENUMBRA_FAIL_FILE_UNDER count, where it is set: a driver has a cache.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

std::atomic<long> calls{0};

template <class F>
F real(F, const char* name) {
    return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

const char* how() {
    static const char* text = std::getenv("PENUMBRA_FAIL_FILE_HOW");
    return text ? text : "";
}

bool is_under(const char* path) {
    static const char* folder = std::getenv("PENUMBRA_FAIL_FILE_UNDER");
    return !folder || !std::strncmp(path, folder, std::strlen(folder));
}
bool is_under(int file) {
    char link[32], path[4096];
    std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    const ssize_t length = ::readlink(link, path, sizeof path - 1);
    path[length < 0 ? 0 : length] = 0;
    return is_under(path);
}

template <class Where>
bool is_next(const char* name, Where where) {
    if (!is_under(where)) return false;
    static const char* text = std::getenv("PENUMBRA_FAIL_FILE_AT");
    static const long wanted = text ? std::atol(text) : -1;
    if (++calls != wanted) return false;
    char line[64];
    const int length = std::snprintf(line, sizeof line, "[fault in %s]\n", name);
    static_cast<void>(real(&::write, "write")(2, line, static_cast<size_t>(length)));
    if (!std::strcmp(how(), "kill")) ::raise(SIGKILL);
    return true;
}

// Whether the call fails, with errno set.
template <class Where>
bool fails(const char* name, Where where) {
    if (!is_next(name, where)) return false;
    const int error = std::atoi(how());
    if (error) errno = error;
    return error != 0;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(more, mode_t) : 0;
    va_end(more);
    if ((flags & O_CREAT) && fails("open", path)) return -1;
    return real(static_cast<int (*)(const char*, int, ...)>(&::open), "open")(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(more, mode_t) : 0;
    va_end(more);
    return open(path, flags, mode);
}
ssize_t write(int file, const void* bytes, size_t count) {
    if (file > 2 && is_next("write", file)) {
        if (!std::strcmp(how(), "short")) {
            count = (count + 1) / 2;
        } else if ((errno = std::atoi(how()))) {
            return -1;
        }
    }
    return real(&::write, "write")(file, bytes, count);
}
int fsync(int file) {
    return fails("fsync", file) ? -1 : real(&::fsync, "fsync")(file);
}
int ftruncate(int file, off_t length) noexcept {
    return fails("ftruncate", file) ? -1 : real(&::ftruncate, "ftruncate")(file, length);
}
int flock(int file, int operation) noexcept {
    return fails("flock", file) ? -1 : real(&::flock, "flock")(file, operation);
}
int rename(const char* from, const char* to) noexcept {
    return fails("rename", to) ? -1 : real(&::rename, "rename")(from, to);
}

}  // extern "C"
