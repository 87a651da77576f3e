// The extension module behind the Python package: the C interface with numpy arrays for buffers. The interpreter's lock
// is released while the library works, and Ctrl-C asks it to stop.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "device/library/ldp.h"

namespace py = pybind11;

namespace {

constexpr auto kSignalsLookedFor = std::chrono::milliseconds(50);

[[noreturn]] void raise(const ldp_error& error) {
  switch (error.status) {
    case LDP_BAD_ARGUMENT:
      throw py::value_error(error.message);
    case LDP_OUT_OF_MEMORY:
      PyErr_SetString(PyExc_MemoryError, error.message);
      break;
    case LDP_NOT_READABLE:
      PyErr_SetString(PyExc_OSError, error.message);
      break;
    case LDP_STOPPED:
      PyErr_SetString(PyExc_KeyboardInterrupt, "");
      break;
    default:
      PyErr_SetString(py::module_::import("ldp.errors")
                          .attr(error.status == LDP_DAMAGED         ? "DamagedError"
                                : error.status == LDP_BEYOND_LIMITS ? "LimitError"
                                                                    : "Error")
                          .ptr(),
                      error.message);
  }
  throw py::error_already_set();
}

template <typename Call>
void checked(const Call& call) {
  ldp_error error{};
  if (call(&error) != LDP_OK) raise(error);
}

bool on_main_thread() {
  const py::module_ threading = py::module_::import("threading");
  return threading.attr("current_thread")().is(threading.attr("main_thread")());
}

// Python handles signals on its main thread only, so the work is done on another one meanwhile.
template <typename Call>
void interruptible(const Call& call) {
  const std::unique_ptr<ldp_stop, decltype(&ldp_stop_free)> stop(ldp_stop_new(), ldp_stop_free);
  ldp_error error{};
  ldp_status status = LDP_OK;
  if (!on_main_thread()) {
    const py::gil_scoped_release released;
    status = call(stop.get(), &error);
  } else {
    auto work = std::async(std::launch::async, [&] { return call(stop.get(), &error); });
    const auto ready = [&] {
      const py::gil_scoped_release released;
      return work.wait_for(kSignalsLookedFor) == std::future_status::ready;
    };
    while (!ready()) {
      if (PyErr_CheckSignals() == 0) continue;
      ldp_stop_request(stop.get());
      const py::error_already_set interrupt;
      {
        const py::gil_scoped_release released;
        work.wait();
      }
      throw interrupt;
    }
    status = work.get();
  }
  if (status != LDP_OK) raise(error);
}

template <typename Sample>
py::array_t<Sample> plane(py::ssize_t height, py::ssize_t width) {
  return py::array_t<Sample>(std::vector<py::ssize_t>{height, width});
}

py::array_t<uint8_t> picture(py::ssize_t height, py::ssize_t width) {
  return py::array_t<uint8_t>(std::vector<py::ssize_t>{height, width, 3});
}

using Matrix = py::array_t<double, py::array::c_style | py::array::forcecast>;

ldp_camera camera_from(int width, int height, const std::array<double, 8>& lens, const Matrix& pose) {
  if (pose.ndim() != 2 || pose.shape(0) != 4 || pose.shape(1) != 4)
    throw py::value_error("pose: must be a 4x4 matrix, camera to world");
  ldp_camera camera = LDP_INIT(ldp_camera);
  camera.width = width, camera.height = height;
  camera.fl_x = lens[0], camera.fl_y = lens[1], camera.cx = lens[2], camera.cy = lens[3];
  camera.k1 = lens[4], camera.k2 = lens[5], camera.p1 = lens[6], camera.p2 = lens[7];
  std::copy_n(pose.data(), 16, camera.world_from_camera);
  return camera;
}

// width, height, (fl_x fl_y cx cy k1 k2 p1 p2), pose
py::tuple tuple_of(const ldp_camera& c) {
  Matrix pose(std::vector<py::ssize_t>{4, 4});
  std::copy_n(c.world_from_camera, 16, pose.mutable_data());
  return py::make_tuple(c.width, c.height, py::make_tuple(c.fl_x, c.fl_y, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2), pose);
}

class File {
 public:
  static std::unique_ptr<File> open(const std::string& path, uint64_t pixels, uint64_t memory) {
    auto file = std::make_unique<File>();
    const ldp_limits limits = limits_of(pixels, memory);
    interruptible(
        [&](ldp_stop*, ldp_error* error) { return ldp_open_file(path.c_str(), &limits, &file->held_, error); });
    return file;
  }
  static std::unique_ptr<File> from_bytes(const py::bytes& bytes, uint64_t pixels, uint64_t memory) {
    auto file = std::make_unique<File>();
    const ldp_limits limits = limits_of(pixels, memory);
    const std::string_view view = bytes;
    checked([&](ldp_error* error) { return ldp_open_memory(view.data(), view.size(), &limits, &file->held_, error); });
    return file;
  }
  File() = default;
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() { ldp_close(held_); }

  ldp_panorama* held() const { return held_; }

  ldp_description description() const {
    ldp_description told = LDP_INIT(ldp_description);
    checked([&](ldp_error* error) { return ldp_describe(held_, &told, error); });
    return told;
  }

  ldp_layer_description layer(int index) const {
    ldp_layer_description told = LDP_INIT(ldp_layer_description);
    checked([&](ldp_error* error) { return ldp_describe_layer(held_, index, &told, error); });
    return told;
  }

  py::list cameras() const {
    py::list all;
    for (int i = 0; i < description().cameras; ++i) {
      ldp_camera camera = LDP_INIT(ldp_camera);
      const char* name = nullptr;
      checked([&](ldp_error* error) { return ldp_get_camera(held_, i, &camera, &name, error); });
      all.append(py::make_tuple(std::string(name), tuple_of(camera)));
    }
    return all;
  }

  py::dict quality() const {
    py::dict all;
    for (int i = 0; i < description().quality_figures; ++i) {
      const char* name = nullptr;
      double value = 0;
      checked([&](ldp_error* error) { return ldp_get_quality(held_, i, &name, &value, error); });
      all[name] = value;
    }
    return all;
  }

  py::dict metadata() const {
    py::dict all;
    for (int i = 0; i < description().metadata_entries; ++i) {
      const char *name = nullptr, *value = nullptr;
      checked([&](ldp_error* error) { return ldp_get_metadata(held_, i, &name, &value, error); });
      all[name] = value;
    }
    return all;
  }

  py::bytes thumbnail() const {
    const uint8_t* bytes = nullptr;
    size_t count = 0;
    checked([&](ldp_error* error) { return ldp_get_thumbnail(held_, &bytes, &count, error); });
    return {reinterpret_cast<const char*>(bytes), count};
  }

  void verify() const {
    interruptible([&](ldp_stop* stop, ldp_error* error) { return ldp_verify(held_, stop, error); });
  }

  void prepare(int threads) const {
    interruptible([&](ldp_stop* stop, ldp_error* error) { return ldp_prepare(held_, threads, stop, error); });
  }

  // depth, disparity, coverage, alpha, rgb or None; columns begin to end.
  py::tuple planes(int layer, int begin, int end, bool with_rgb, int threads) const {
    const ldp_description grid = description();
    const int width = begin == 0 && end == 0 ? grid.width : end - begin;
    if (width < 1 || width > grid.width) throw py::value_error("columns: are not within the panorama");
    auto depth = plane<float>(grid.height, width);
    auto disparity = plane<uint16_t>(grid.height, width);
    auto coverage = plane<uint8_t>(grid.height, width), alpha = plane<uint8_t>(grid.height, width);
    std::optional<py::array_t<uint8_t>> rgb;
    if (with_rgb) rgb = picture(grid.height, width);
    ldp_planes wanted = LDP_INIT(ldp_planes);
    wanted.begin = begin, wanted.end = end, wanted.threads = threads;
    wanted.depth = depth.mutable_data(), wanted.disparity = disparity.mutable_data();
    wanted.coverage = coverage.mutable_data(), wanted.alpha = alpha.mutable_data();
    wanted.rgb = rgb ? rgb->mutable_data() : nullptr;
    interruptible([&](ldp_stop* stop, ldp_error* error) {
      wanted.stop = stop;
      return ldp_read_planes(held_, layer, &wanted, error);
    });
    return py::make_tuple(depth, disparity, coverage.attr("view")("bool"), alpha, rgb);
  }

  py::tuple render(const ldp_camera& camera, int layers, bool fill, bool with_depth, int threads) const {
    if (camera.width < 1 || camera.height < 1) throw py::value_error("size: must be at least one pixel");
    auto rgb = picture(camera.height, camera.width);
    auto alpha = plane<uint8_t>(camera.height, camera.width);
    std::optional<py::array_t<float>> depth;
    if (with_depth) depth = plane<float>(camera.height, camera.width);
    ldp_view view = LDP_INIT(ldp_view);
    view.layers = layers, view.threads = threads;
    view.fill = fill ? LDP_FILL_BACKGROUND : LDP_FILL_NONE;
    view.rgb = rgb.mutable_data(), view.alpha = alpha.mutable_data();
    view.depth = depth ? depth->mutable_data() : nullptr;
    interruptible([&](ldp_stop* stop, ldp_error* error) {
      view.stop = stop;
      return ldp_render(held_, &camera, &view, error);
    });
    return py::make_tuple(rgb, alpha, depth);
  }

  py::list path(const std::string& kind, int frames, int width, int height, double fov_rad) const {
    if (frames < 1 || frames > 100000) throw py::value_error("frames: must be 1 to 100000");
    std::vector<ldp_camera> cameras(static_cast<size_t>(frames));
    cameras[0] = LDP_INIT(ldp_camera);
    cameras[0].width = width, cameras[0].height = height;
    checked([&](ldp_error* error) {
      return ldp_cameras_on_path(held_, kind.c_str(), frames, fov_rad, cameras.data(), error);
    });
    py::list all;
    for (const ldp_camera& camera : cameras) all.append(tuple_of(camera));
    return all;
  }

 private:
  static ldp_limits limits_of(uint64_t pixels, uint64_t memory) {
    ldp_limits limits = LDP_INIT(ldp_limits);
    limits.pixels = pixels, limits.memory_bytes = memory;
    return limits;
  }

  ldp_panorama* held_ = nullptr;
};

class Writer {
 public:
  explicit Writer(const ldp_description& description) {
    checked([&](ldp_error* error) { return ldp_writer_new(&description, &held_, error); });
    width_ = description.width, height_ = description.height;
  }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer() { ldp_writer_free(held_); }

  void add_layer(const py::array_t<float, py::array::c_style | py::array::forcecast>& depth,
                 const py::array_t<uint8_t, py::array::c_style>& rgb,
                 const std::optional<py::array_t<uint8_t, py::array::c_style>>& alpha, int block_px) {
    check_shape("depth", depth, 2);
    check_shape("rgb", rgb, 3);
    if (alpha) check_shape("alpha", *alpha, 2);
    ldp_planes planes = LDP_INIT(ldp_planes);
    planes.depth = const_cast<float*>(depth.data());  // of a writer they are read only
    planes.rgb = const_cast<uint8_t*>(rgb.data());
    planes.alpha = alpha ? const_cast<uint8_t*>(alpha->data()) : nullptr;
    interruptible([&](ldp_stop*, ldp_error* error) { return ldp_writer_add_layer(held_, &planes, block_px, error); });
  }
  void add_camera(const std::string& name, const ldp_camera& camera) {
    checked([&](ldp_error* error) { return ldp_writer_add_camera(held_, name.c_str(), &camera, error); });
  }
  void set_quality(const std::string& name, double value) {
    checked([&](ldp_error* error) { return ldp_writer_set_quality(held_, name.c_str(), value, error); });
  }
  void set_metadata(const std::string& name, const std::string& value) {
    checked([&](ldp_error* error) { return ldp_writer_set_metadata(held_, name.c_str(), value.c_str(), error); });
  }
  void save(const std::string& path, int colour_quality) const {
    interruptible(
        [&](ldp_stop*, ldp_error* error) { return ldp_writer_save(held_, path.c_str(), colour_quality, error); });
  }

 private:
  void check_shape(const char* name, const py::array& array, py::ssize_t dimensions) const {
    if (array.ndim() != dimensions || array.shape(0) != height_ || array.shape(1) != width_ ||
        (dimensions == 3 && array.shape(2) != 3))
      throw py::value_error(std::string(name) + ": must be of shape (" + std::to_string(height_) + ", " +
                            std::to_string(width_) + (dimensions == 3 ? ", 3)" : ")"));
  }

  ldp_writer* held_ = nullptr;
  py::ssize_t width_ = 0, height_ = 0;
};

template <size_t Count>
std::vector<double> listed(const double (&values)[Count]) {
  return {values, values + Count};
}

}  // namespace

PYBIND11_MODULE(_ldp, module) {
  module.def("version", ldp_version);
  py::class_<ldp_description>(module, "Description")
      .def_readonly("format_version", &ldp_description::format_version)
      .def_readonly("file_bytes", &ldp_description::file_bytes)
      .def_readonly("width", &ldp_description::width)
      .def_readonly("height", &ldp_description::height)
      .def_readonly("layers", &ldp_description::layers)
      .def_property_readonly("central", [](const ldp_description& d) { return d.rays == LDP_RAYS_CENTRAL; })
      .def_property_readonly("wraps", [](const ldp_description& d) { return d.wraps != 0; })
      .def_property_readonly("arc_closed", [](const ldp_description& d) { return d.arc_closed != 0; })
      .def_readonly("theta_left", &ldp_description::theta_left)
      .def_readonly("theta_pitch", &ldp_description::theta_pitch)
      .def_readonly("v_top", &ldp_description::v_top)
      .def_readonly("v_pitch", &ldp_description::v_pitch)
      .def_readonly("far_inverse_depth", &ldp_description::far_inverse_depth)
      .def_readonly("near_inverse_depth", &ldp_description::near_inverse_depth)
      .def_property_readonly("arc_centre", [](const ldp_description& d) { return listed(d.arc_centre); })
      .def_property_readonly("world_from_arc", [](const ldp_description& d) { return listed(d.world_from_arc); })
      .def_readonly("arc_radius", &ldp_description::arc_radius)
      .def_readonly("theta_begin", &ldp_description::theta_begin)
      .def_readonly("theta_end", &ldp_description::theta_end)
      .def_readonly("inner_radius", &ldp_description::inner_radius)
      .def_readonly("outer_radius", &ldp_description::outer_radius)
      .def_readonly("max_height", &ldp_description::max_height);
  py::class_<ldp_layer_description>(module, "LayerDescription")
      .def_readonly("block_px", &ldp_layer_description::block_px)
      .def_readonly("has_alpha", &ldp_layer_description::has_alpha)
      .def_readonly("present_pixels", &ldp_layer_description::present_pixels);
  py::class_<ldp_camera>(module, "Camera").def(py::init(&camera_from));
  py::class_<File>(module, "File")
      .def_static("open", &File::open)
      .def_static("from_bytes", &File::from_bytes)
      .def("description", &File::description)
      .def("layer", &File::layer)
      .def("cameras", &File::cameras)
      .def("quality", &File::quality)
      .def("metadata", &File::metadata)
      .def("thumbnail", &File::thumbnail)
      .def("verify", &File::verify)
      .def("prepare", &File::prepare)
      .def("planes", &File::planes)
      .def("render", &File::render)
      .def("path", &File::path);
  py::class_<Writer>(module, "Writer")
      .def(py::init<const ldp_description&>())
      .def("add_layer", &Writer::add_layer)
      .def("add_camera", &Writer::add_camera)
      .def("set_quality", &Writer::set_quality)
      .def("set_metadata", &Writer::set_metadata)
      .def("save", &Writer::save);
}
