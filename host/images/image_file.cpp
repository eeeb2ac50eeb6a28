// SPDX-License-Identifier: MIT
// Encoders write to memory, so that there is one place where a file can fail (OpenEXR's own closes files in a
// destructor, which cannot report a full disk).
#include "host/images/image_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStdIO.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "host/images/exr_header.h"
#include "host/images/srgb.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

namespace penumbra {

namespace {

Imf::PixelType pixel_type(PlaneType type) {
    switch (type) {
        case PlaneType::half:
            return Imf::HALF;
        case PlaneType::real:
            return Imf::FLOAT;
        case PlaneType::uint:
            return Imf::UINT;
    }
    throw std::invalid_argument("pixel_type: not a plane type");
}

// A slice over a full plane whose first texel is `data`, for an image whose data window starts at (x0, y0).
// OpenEXR asks for the address of texel (0, 0), which may lie anywhere: it is an integer that wraps until the
// window's corner is added again.
template <class T>
Imf::Slice slice(Imf::PixelType type, T* data, size_t width, int64_t x0, int64_t y0) {
    const auto first = static_cast<uint64_t>(y0) * width + static_cast<uint64_t>(x0);
    const uintptr_t base = reinterpret_cast<uintptr_t>(data) - first * sizeof(T);
    return {type, reinterpret_cast<char*>(base), sizeof(T), sizeof(T) * width};
}

uint8_t to_byte(double value) {
    return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 1.0) * 255));
}

std::vector<std::byte> png_of(uint32_t width, uint32_t height, int channels,
                              std::span<const uint8_t> texels) {
    std::vector<std::byte> bytes;
    const auto append = [](void* to, void* data, int size) {
        const auto* from = static_cast<const std::byte*>(data);
        static_cast<std::vector<std::byte>*>(to)->insert(static_cast<std::vector<std::byte>*>(to)->end(),
                                                         from, from + size);
    };
    if (!stbi_write_png_to_func(append, &bytes, static_cast<int>(width), static_cast<int>(height), channels,
                                texels.data(), static_cast<int>(width) * channels)) {
        throw FileError(fmt::format("a PNG of {} x {} texels cannot be encoded", width, height));
    }
    return bytes;
}

void put(std::vector<uint8_t>& rgb, size_t pixel, bool nan, uint8_t r, uint8_t g, uint8_t b) {
    rgb[3 * pixel] = nan ? 255 : r;
    rgb[3 * pixel + 1] = nan ? 0 : g;
    rgb[3 * pixel + 2] = nan ? 255 : b;
}

// A call that a signal ends is made again.
template <class Call>
auto uninterrupted(Call call) {
    for (;;)
        if (const auto result = call(); result >= 0 || errno != EINTR) return result;
}

// The file beside `path` that it is written to first, opened and locked; -1 with errno. Its name is the same
// for every process: what a killed one left is overwritten by whoever writes that file next, and the lock,
// which ends with its process, keeps two that live apart.
int open_part(const std::string& part) {
    for (;;) {
        const int file = uninterrupted(
            [&] { return ::open(part.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666); });
        if (file < 0) return -1;
        struct stat opened {
        }, named{};
        const bool locked = uninterrupted([&] { return ::flock(file, LOCK_EX); }) == 0 || errno == ENOLCK;
        // Who held the lock before has given the file its final name: this is no longer the part.
        const bool same = ::fstat(file, &opened) == 0 && ::stat(part.c_str(), &named) == 0 &&
                          opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
        if (locked && same && uninterrupted([&] { return ::ftruncate(file, 0); }) == 0) return file;
        const int error = errno;
        if (same) ::unlink(part.c_str());
        ::close(file);
        if (locked && !same) continue;
        errno = error;
        return -1;
    }
}

// 0, or the error. The bytes are on the disk before the file gets its name: a machine that loses power
// between the two would else keep the name of an empty file.
int write_all(int file, std::span<const std::byte> bytes) {
    for (size_t done = 0; done < bytes.size();) {
        const ssize_t count =
            uninterrupted([&] { return ::write(file, bytes.data() + done, bytes.size() - done); });
        if (count <= 0) return count < 0 ? errno : EIO;
        done += static_cast<size_t>(count);
    }
    // Pipes and some file systems cannot flush.
    return uninterrupted([&] { return ::fsync(file); }) == 0 || errno == EINVAL || errno == ENOTSUP ? 0
                                                                                                    : errno;
}

// 0, or the error. Into what is no regular file, as a device or a pipe: nothing may be put in its place.
int write_into(const std::filesystem::path& path, std::span<const std::byte> bytes) {
    const int file = uninterrupted([&] { return ::open(path.c_str(), O_WRONLY | O_CLOEXEC); });
    const int error = file < 0 ? errno : write_all(file, bytes);
    if (file >= 0) ::close(file);
    return error;
}

// Where links lead to, be there a file or not.
std::filesystem::path behind_links(std::filesystem::path path) {
    for (std::error_code none; std::filesystem::is_symlink(path, none);)
        path = path.parent_path() / std::filesystem::read_symlink(path, none);
    return path;
}

// The name itself. The file is whole under it already, so what fails here takes nothing away.
void flush_folder(const std::filesystem::path& path) {
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) return;
    ::fsync(file);
    ::close(file);
}

}  // namespace

const Plane* PlanarImage::find(std::string_view name) const {
    const auto found = std::ranges::find(planes, name, &Plane::name);
    return found == planes.end() ? nullptr : &*found;
}

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
    int file = -1;
    std::string part;
    const auto fail = [&](const char* verb, int error) {
        if (file >= 0) {
            ::unlink(part.c_str());
            ::close(file);
        }
        throw FileError(fmt::format("{}: cannot be {}: {}", path.string(), verb, std::strerror(error)));
    };
    std::error_code failure;
    const std::filesystem::file_status there = std::filesystem::status(path, failure);
    if (there.type() == std::filesystem::file_type::none) fail("written", failure.value());
    if (exists(there) && !is_regular_file(there)) {
        if (const int error = write_into(path, bytes)) fail("written", error);
        return;
    }
    const std::filesystem::path target = behind_links(path);
    part = target.string() + ".part";  // beside it: a rename does not cross file systems
    file = open_part(part);
    if (file < 0) fail("written", errno);
    if (const int error = write_all(file, bytes)) fail("written", error);
    if (uninterrupted([&] { return ::rename(part.c_str(), target.c_str()); }) != 0)
        fail("put in place", errno);
    ::close(file);
    flush_folder(target);
}

void write_exr(const std::filesystem::path& path, const PlanarImage& image) {
    const size_t texels = size_t(image.width) * image.height;
    Imf::Header header(static_cast<int>(image.width), static_cast<int>(image.height));
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer frame;
    std::vector<std::vector<half>> halves;
    halves.reserve(image.planes.size());
    for (const Plane& plane : image.planes) {
        const size_t size = plane.type == PlaneType::uint ? plane.words.size() : plane.values.size();
        if (size != texels)
            throw std::invalid_argument("write_exr: plane " + plane.name + " has the wrong size");
        const Imf::PixelType type = pixel_type(plane.type);
        header.channels().insert(plane.name, Imf::Channel(type));
        switch (plane.type) {
            case PlaneType::uint:
                frame.insert(plane.name, slice(type, plane.words.data(), image.width, 0, 0));
                break;
            case PlaneType::real:
                frame.insert(plane.name, slice(type, plane.values.data(), image.width, 0, 0));
                break;
            case PlaneType::half:
                halves.emplace_back(plane.values.begin(), plane.values.end());
                frame.insert(plane.name, slice(type, halves.back().data(), image.width, 0, 0));
                break;
        }
    }
    std::string bytes;
    try {
        Imf::StdOSStream stream;
        {
            Imf::OutputFile file(stream, header);
            file.setFrameBuffer(frame);
            file.writePixels(static_cast<int>(image.height));
        }  // the table of lines is written here
        bytes = stream.str();
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        throw FileError(fmt::format("{}: the EXR cannot be encoded: {}", path.string(), error.what()));
    }
    write_file(path, std::as_bytes(std::span(bytes)));
}

std::optional<PlanarImage> read_exr(const std::filesystem::path& path, Diagnostics& diagnostics) {
    const Place place{path.string(), 0, 0};
    if (std::error_code failure; !std::filesystem::is_regular_file(path, failure)) {
        const bool unknown = failure && failure != std::errc::no_such_file_or_directory;
        diagnostics.add(place, "", unknown ? "cannot be read: " + failure.message() : "no such file");
        return std::nullopt;
    }
    try {
        if (const auto problem = exr_size_problem(path)) {
            diagnostics.add(place, "", *problem);
            return std::nullopt;
        }
        Imf::InputFile file(path.string().c_str());
        const Imath::Box2i window = file.header().dataWindow();
        const int64_t width = int64_t(window.max.x) - window.min.x + 1,
                      height = int64_t(window.max.y) - window.min.y + 1;
        PlanarImage image{static_cast<uint32_t>(width), static_cast<uint32_t>(height), {}};
        const size_t texels = size_t(image.width) * image.height;
        const Imf::ChannelList& channels = file.header().channels();
        for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
            if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1) {
                diagnostics.add(place, channel.name(), "sub-sampled channels are not supported");
                return std::nullopt;
            }
            Plane& plane = image.planes.emplace_back();
            plane.name = channel.name();
            plane.type = channel.channel().type == Imf::HALF   ? PlaneType::half
                         : channel.channel().type == Imf::UINT ? PlaneType::uint
                                                               : PlaneType::real;
            if (plane.type == PlaneType::uint) {
                plane.words.resize(texels);
            } else {
                plane.values.resize(texels);
            }
        }
        Imf::FrameBuffer frame;
        for (Plane& plane : image.planes) {
            if (plane.type == PlaneType::uint) {
                frame.insert(plane.name,
                             slice(Imf::UINT, plane.words.data(), image.width, window.min.x, window.min.y));
            } else {  // OpenEXR widens halves
                frame.insert(plane.name,
                             slice(Imf::FLOAT, plane.values.data(), image.width, window.min.x, window.min.y));
            }
        }
        file.setFrameBuffer(frame);
        file.readPixels(window.min.y, window.max.y);
        return image;
    } catch (const std::bad_alloc&) {
        throw;  // the file is not to blame
    } catch (const std::exception& error) {
        diagnostics.add(place, "", error.what());
        return std::nullopt;
    }
}

std::vector<std::byte> png_of_rgba(uint32_t width, uint32_t height, std::span<const uint8_t> rgba) {
    if (rgba.size() != size_t{width} * height * 4)
        throw std::invalid_argument("png_of_rgba: not four values per texel");
    return png_of(width, height, 4, rgba);
}

float exposed(float radiance) {
    return std::isnan(radiance) ? radiance : -std::expm1(-std::max(radiance, 0.0f));
}

void write_png_color(const std::filesystem::path& path, uint32_t width, uint32_t height,
                     std::span<const float> rgb) {
    const size_t texels = size_t(width) * height;
    if (rgb.size() != texels * 3) throw std::invalid_argument("write_png_color: not three values per texel");
    std::vector<uint8_t> bytes(texels * 3);
    for (size_t i = 0; i < texels; ++i) {
        const double r = rgb[3 * i], g = rgb[3 * i + 1], b = rgb[3 * i + 2];
        const bool nan = std::isnan(r) || std::isnan(g) || std::isnan(b);
        if (nan) {
            put(bytes, i, true, 0, 0, 0);
        } else {
            put(bytes, i, false, to_byte(srgb_of_linear(r)), to_byte(srgb_of_linear(g)),
                to_byte(srgb_of_linear(b)));
        }
    }
    write_file(path, png_of(width, height, 3, bytes));
}

void write_png_light(const std::filesystem::path& path, uint32_t width, uint32_t height,
                     std::span<const float> rgb) {
    std::vector<float> shown(rgb.begin(), rgb.end());
    for (float& value : shown) value = exposed(value);
    write_png_color(path, width, height, shown);
}

void write_png_linear(const std::filesystem::path& path, uint32_t width, uint32_t height,
                      std::span<const float> values) {
    const size_t texels = size_t(width) * height;
    if (values.size() != texels) throw std::invalid_argument("write_png_linear: not one value per texel");
    std::vector<uint8_t> bytes(texels * 3);
    for (size_t i = 0; i < texels; ++i) {
        const bool nan = std::isnan(values[i]);
        const uint8_t grey = nan ? uint8_t(0) : to_byte(values[i]);
        put(bytes, i, nan, grey, grey, grey);
    }
    write_file(path, png_of(width, height, 3, bytes));
}

}  // namespace penumbra
