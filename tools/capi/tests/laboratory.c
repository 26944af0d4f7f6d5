/* Reads data of laboratories: forces, events, a skeleton from markers, angles, a walk.
 *
 *     laboratory plates.c3d markers.c3d walk.bvh short.bvh output.glb
 */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <mocap.h>

static void check(int holds, const char *what)
{
    if (!holds) {
        fprintf(stderr, "%s: %s\n", what, mocap_error_text());
        exit(1);
    }
}

/* The value of the column with this name and unit. */
static double value(const mocap_table *table, size_t row, const char *name, const char *unit)
{
    size_t columns = mocap_table_column_count(table);
    for (size_t column = 0; column < columns; column++) {
        if (strcmp(mocap_table_name(table, column), name) == 0) {
            check(strcmp(mocap_table_unit(table, column), unit) == 0, "unit");
            return mocap_table_values(table)[row * columns + column];
        }
    }
    check(0, name);
    return 0;
}

static void has(const mocap_scene *scene, const char *what, const char *expected)
{
    char *report = mocap_report(scene, what);
    check(report != NULL && strstr(report, expected) != NULL, expected);
    mocap_text_free(report);
}

/* Surveys a file, writes it in another format, and compares both. */
static void look(const char *path, const char *output)
{
    char job[4096];
    snprintf(job, sizeof job, "{\"source\": {\"inputs\": [\"%s\"]}, \"survey\": {}}", path);
    char *survey = mocap_run(job);
    check(survey != NULL && strstr(survey, "\"survey\":[{") != NULL && strstr(survey, "\"joints\":31") != NULL, "a row");
    mocap_text_free(survey);

    snprintf(job, sizeof job, "{\"source\": {\"inputs\": [\"%s\"]}, \"write\": {\"output\": \"%s\"}}", path, output);
    char *report = mocap_run(job);
    check(report != NULL, "a job");
    mocap_text_free(report);
    char *verified = mocap_verify(path, output);
    check(verified != NULL && strstr(verified, "\"findings\":[]") != NULL, "an output that is its source");
    mocap_text_free(verified);
    check(mocap_verify(path, "no such file") == NULL && strstr(mocap_error_text(), "no such file") != NULL, "no file");
    check(mocap_verify(NULL, output) == NULL && strstr(mocap_error_text(), "source") != NULL, "no source");
    check(mocap_score(path, output, path, NULL) == NULL && strstr(mocap_error_text(), "robot") != NULL, "no robot");
}

int main(int count, char **arguments)
{
    check(count == 6, "five files are needed");

    mocap_scene *plates = mocap_open_file(arguments[1]);
    check(plates != NULL, arguments[1]);
    mocap_table *forces = mocap_table_new(plates, "forces");
    check(forces != NULL, "forces");
    check(mocap_table_rate(forces) == 400 && mocap_table_row_count(forces) == 80, "rows");
    /* The expected numbers come from ezc3d; see src/cli/tests/it/c3d_recorded.rs. */
    check(fabs(value(forces, 40, "ground_force_1_vy", "N") - 779.14866) < 1e-3, "force");
    check(fabs(value(forces, 40, "ground_force_1_px", "m") - 0.16927582) < 1e-6, "centre");
    mocap_table *analog = mocap_table_new(plates, "analog");
    check(fabs(value(analog, 40, "EMG", "V") + 2.5421e-5) < 1e-8, "analog");
    has(plates, "recorded", "\"Foot Strike\"");
    has(plates, "solved", "null");
    check(mocap_table_new(plates, "angles") == NULL, "points have no angles");
    check(mocap_table_new(plates, "weight") == NULL && strstr(mocap_error_text(), "weight") != NULL, "no such table");
    check(mocap_table_name(forces, 27) == NULL && mocap_table_unit(forces, 27) == NULL, "no such column");
    mocap_close(plates);
    check(mocap_table_column_count(forces) == 27, "a table does not need its scene");
    mocap_table_free(forces);
    mocap_table_free(analog);

    mocap_scene *solved = mocap_open_file_as(arguments[2], "{\"markers\": \"auto\"}");
    check(solved != NULL, arguments[2]);
    check(mocap_find_node(solved, "leftLowerLeg") != MOCAP_NO_NODE, "a knee");
    has(solved, "solved", "\"landmark\":\"LASI\"");
    mocap_close(solved);
    check(mocap_open_file_as(arguments[2], "{\"marker\": 1}") == NULL && strstr(mocap_error_text(), "marker") != NULL,
          "an option that there is not");

    mocap_scene *walk = mocap_open_file_as(arguments[3], NULL);
    check(walk != NULL, arguments[3]);
    mocap_table *angles = mocap_table_new(walk, "angles");
    double most = 0;
    for (size_t row = 0; row < mocap_table_row_count(angles); row++)
        most = fmax(most, value(angles, row, "knee_angle_r", "deg"));
    check(most > 50 && most < 80, "knees of a walk bend by about 60 degrees");
    has(walk, "gait", "\"cadence\":");
    has(walk, "inspect", "\"joints\":31,");
    has(walk, "bones", "\"leftLowerLeg\":{\"joint\":");
    look(arguments[4], arguments[5]);
    check(mocap_report(walk, "weather") == NULL, "no such report");
    check(mocap_table_values(NULL) == NULL && mocap_table_row_count(NULL) == 0 && mocap_table_rate(NULL) == 0, "no table");
    mocap_table_free(angles);
    mocap_table_free(NULL);
    mocap_close(walk);
    printf("the laboratory has what it asked for\n");
    return 0;
}
