/* SPDX-License-Identifier: MIT */
/* `lcor paper`: the paper's experiments as data. */
#include "paper.h"
#include "message.h"
#include "render.h"
#include "stream.h"

#include <cerrno>
#include <cstring>
#include <sys/stat.h>

namespace cli
{

namespace
{

struct PaperOptions {
    std::string folder;
    std::vector<std::string> textures;
    double contrast = 23.4;
    PictureSize size = {1024, 768};
    int threads = 0;
};

void make_folder(const std::string &folder)
{
    if (mkdir(folder.c_str(), 0777) == 0)
        return;
    struct stat info;
    if (errno == EEXIST && stat(folder.c_str(), &info) == 0 && S_ISDIR(info.st_mode))
        return;
    fail(errno == EACCES ? Exit::permission : Exit::failed, "cannot make the folder '%s': %s",
         folder.c_str(),
         errno == EEXIST ? "a file of that name is in the way" : std::strerror(errno));
}

void write_image(const std::string &path, const Image &image)
{
    OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height),
                         static_cast<int>(image.channels), OIIO::TypeDesc::UINT8);
    PictureWriter writer(path, spec);
    writer.write(0, image.height, OIIO::TypeDesc::UINT8, image.bytes.data());
    writer.commit();
}

/* Files of floor, walls and ceiling: those given, else patterns. */
std::vector<std::string> textures_of(const PaperOptions &paper)
{
    std::vector<std::string> files = paper.textures;
    const char *const names[] = {"floor", "wall", "ceiling"};
    for (size_t i = files.size(); i < 3; i++) {
        files.push_back(paper.folder + "/texture_" + names[i] + ".png");
        write_image(files.back(), paper_pattern(static_cast<int>(i)));
    }
    return files;
}

/* Table 3, with 2,500 patches a face and one lamp. */
Scene table3(const std::vector<std::string> &textures, const std::string &path, Threads &threads)
{
    Arguments arguments = {"-o", path, "--patches", "50"};
    const std::pair<const char *, size_t> faces[] = {{"floor", 0}, {"x0", 1}, {"x1", 1},
                                                     {"y0", 1},    {"y1", 1}, {"ceiling", 2}};
    for (const auto &[face, texture] : faces) {
        arguments.push_back("--texture");
        arguments.push_back(std::string(face) + "=" + textures[texture]);
    }
    const bool json = json_wanted();
    set_json(false);
    run_room(arguments);
    set_json(json);
    return load_scene(path, SceneOptions(), threads);
}

struct View {
    const char *camera, *name;
};

/* Both views of Figure 4 by both methods. They share no adaptation: each has its own mean. */
Json figure4(const PaperOptions &paper, const Scene &scene, const lcor_solution *solution,
             const std::string &room, Threads &threads)
{
    Json measured;
    Device device;
    device.contrast = paper.contrast;
    for (const View &view : {View{"side", "figure4a"}, View{"above", "figure4b"}}) {
        const Picture picture(scene, solution,
                              sized_camera(choose_camera(scene, view.camera), paper.size), 1e-3,
                              threads);
        CorrectionOptions correction;
        const double r_mean = mean_over_view(picture, correction, device, std::nullopt);
        for (const bool conventional : {false, true}) {
            correction.conventional = conventional;
            const PlanPointer plan = picture_plan(correction, device, r_mean);
            const Developer developer(picture, plan.get(), conventional, r_mean);
            const char *const method = conventional ? "conventional" : "corrected";
            const Provenance provenance = {
                "lcor paper",
                {room},
                {{"method", method}, {"contrast", device.contrast}, {"r_mean", r_mean}}};
            const lcor_row_stats stats = write_picture(
                paper.folder + "/" + view.name + (conventional ? "_conventional.png" : ".png"),
                picture, developer, PictureFormat(), correction, device, provenance);
            const double all = static_cast<double>(stats.pixels);
            measured[view.camera][method] = {
                {"darker_than_shown_share", static_cast<double>(stats.clipped_low) / all},
                {"lighter_than_shown_share", static_cast<double>(stats.clipped_high) / all},
                {"out_of_gamut_share", static_cast<double>(stats.out_of_gamut) / all}};
        }
        measured[view.camera]["r_mean"] = r_mean;
    }
    return measured;
}

Json table3_json(const Scene &scene, const lcor_solution *solution)
{
    Json faces;
    for (const SurfaceInfo &surface : scene.surfaces)
        faces[scene.groups[surface.group].name] = surface.reflectance;
    return {
        {"patches_a_face", 2500}, {"reflectance", faces}, {"solver", report_json(scene, solution)}};
}

} // namespace

Exit run_paper(const Arguments &arguments)
{
    PaperOptions paper;
    Options options("lcor paper -o DIR [options]",
                    "Repeat the paper's experiments: the room of Table 3 with both views of Figure "
                    "4, the four\n"
                    "pictures of Figure 3, the curves of Table 4 and Figure 5; paper.json holds "
                    "what was measured.");
    options.text("-o", "DIR", paper.folder, "the folder to write, made if missing")
        .list("--texture", "FILE", paper.textures,
              "JPEG or PNG of the floor, then walls, then ceiling; default patterns")
        .number("--contrast", "C", paper.contrast, "of the device, default 23.4 as in section 5.1")
        .custom(
            "--size", "WxH",
            [&](const std::string &text) { paper.size = PictureSize::parse(text); },
            "of Figure 4, default 1024x768")
        .count("--threads", "N", paper.threads, "default: as many as the machine has");
    if (!options.parse(arguments))
        return Exit::ok;
    if (!options.operands().empty())
        fail(Exit::usage, "'%s' is left over; lcor paper takes options only",
             options.operands()[0].c_str());
    if (paper.folder.empty())
        fail(Exit::usage, "where to? give -o DIR");
    if (!(paper.contrast > 1.0))
        fail(Exit::usage, "--contrast must be greater than 1, not %s",
             number_text(paper.contrast).c_str());
    if (paper.textures.size() > 3)
        fail(Exit::usage, "--texture: three at most: floor, walls, ceiling");
    make_folder(paper.folder);
    Threads threads(paper.threads);
    const PaperSetup setup(paper.contrast);
    const std::vector<std::string> textures = textures_of(paper);
    const std::string room = paper.folder + "/room.glb";
    const Scene scene = table3(textures, room, threads);
    const SolutionPointer solution = solve_for_picture(scene, SolveOptions(), threads);
    Json document = {{"software", std::string("lcor ") + lcor_version()},
                     {"contrast", paper.contrast}};
    document["table3"] = table3_json(scene, solution.get());
    document["figure3"] = paper_figure3(setup, read_image(textures[0]), paper.folder);
    document["figure4"] = figure4(paper, scene, solution.get(), room, threads);
    document["figure5"] = paper_figure5(setup, paper.folder);
    write_file(paper.folder + "/paper.json", document.dump(2) + "\n");
    say("%s: figure3a-d.png, figure4a/b.png, figure5.csv, room.glb; measured agreement in "
        "paper.json",
        paper.folder.c_str());
    print_json(document);
    return Exit::ok;
}

} // namespace cli
