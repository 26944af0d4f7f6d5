// Prints Assimp's scene of one file on standard output.
//
//     assimp-dump FILE none|MaxQuality+Debone json|2017|2018|2019|2021
//
// The exit status is 2 on wrong usage, else 0. If Assimp refuses the file, prints {"error": "..."} in every format.

#include "course_text.hpp"
#include "json.hpp"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>

#include <iostream>
#include <map>
#include <string>

int main(int count, char **arguments) {
    const std::map<std::string, unsigned> flags = {
        {"none", 0},
        {"MaxQuality+Debone", aiProcessPreset_TargetRealtime_MaxQuality | aiProcess_Debone},
    };
    const std::map<std::string, course_text::Layout> layouts = {
        {"2017", course_text::Layout::y2017},
        {"2018", course_text::Layout::y2018},
        {"2019", course_text::Layout::y2019},
        {"2021", course_text::Layout::y2021},
    };
    const std::string format = count == 4 ? arguments[3] : "";
    if (count != 4 || flags.count(arguments[2]) == 0 || (format != "json" && layouts.count(format) == 0)) {
        std::cerr << "usage: assimp-dump FILE none|MaxQuality+Debone json|2017|2018|2019|2021\n";
        return 2;
    }
    std::ios::sync_with_stdio(false);

    const aiScene *scene = aiImportFile(arguments[1], flags.at(arguments[2]));
    if (scene == nullptr) {
        json::print_error(std::cout, aiGetErrorString());
    } else if (format == "json") {
        json::print_scene(std::cout, *scene);
    } else {
        course_text::Printer(std::cout, layouts.at(format)).print(*scene);
    }
    aiReleaseImport(scene);
}
