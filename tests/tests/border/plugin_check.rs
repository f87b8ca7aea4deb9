//! `pliant plugin check` on C plugins that violate the interface or crash, and an isolated run of a scene with a plugin that crashes.

use pliant_tests::{Bench, Ran};

/// Compiles the C material of `pliant plugin new` with `fault` appended, which defines the entry of the library.
fn compile_with_fault(bench: &Bench, stem: &str, fault: &str) -> String {
    if !bench.path("sound").exists() {
        bench.pliant(&["plugin", "new", "sound", "--kind", "material", "--lang", "c"]).expect(0);
    }
    let text = format!(
        r#"
#define pliant_entry sound_entry
#include "../sound/src/sound.c"
#undef pliant_entry
extern PLIANT_EXPORT const pliant_library pliant_entry;
{fault}
"#
    );
    bench.compile("lib", stem, &text).display().to_string()
}

/// The entry, with a `create` named `faulty`.
const ENTRY: &str = "const pliant_library pliant_entry = {sizeof(pliant_library), PLIANT_ABI_MAJOR, PLIANT_ABI_MINOR, init, \
                     describe_plugin, faulty};";

/// The entry and a `create` that makes a change to each new instance, `it`.
fn create_with(change: &str) -> String {
    format!(
        "static const pliant_plugin *faulty(const pliant_host *host, const char *id) {{
           const pliant_plugin *p = create(host, id);
           instance *it = p ? (instance *)p->data : NULL;
           if (!it) return NULL;
           {change}
           return &it->plugin;
         }}
         {ENTRY}"
    )
}

/// A `forces` that reads the plane behind the rest data.
const READS_PAST: &str = "
    static pliant_status wide(const pliant_plugin *p, const pliant_batch *b, double *force) {
      size_t e;
      for (e = b->begin; e < b->end; e++) force[3 * (size_t)b->elements[2 * e]] += b->rest_data[2 * b->count + e];
      return forces(p, b, force);
    }
    ";

/// A `forces` that reads the position behind the last, or before the first, and does not use it.
fn looks(at: &str) -> String {
    format!(
        "
    static pliant_status looking(const pliant_plugin *p, const pliant_batch *b, double *force) {{
      (void)*(const volatile double *)(b->x + {at});
      return forces(p, b, force);
    }}
    "
    )
}

/// A `forces` that writes what is there to the force behind the last.
const WRITES_SAME: &str = "
    static pliant_status same(const pliant_plugin *p, const pliant_batch *b, double *force) {
      volatile double *behind = force + 3 * b->nodes;
      *behind = *behind;
      return forces(p, b, force);
    }
    ";

/// An `energy` that writes to a measure, a change within rounding.
const WRITES_MEASURE: &str = "
    static pliant_status writing(const pliant_plugin *p, const pliant_batch *b, double *out) {
      double *measure = (double *)b->measure;
      measure[b->begin] *= 1.0 + 1e-15;
      return energy(p, b, out);
    }
    ";

/// A `forces` that allocates and frees.
const ALLOCATES: &str = "
    static void *volatile kept;
    static pliant_status allocating(const pliant_plugin *p, const pliant_batch *b, double *force) {
      kept = malloc(64);
      free(kept);
      return forces(p, b, force);
    }
    ";

/// `functions`, and the entry of a material with `last` for its functions `forces` and `tangent`.
fn with_material(functions: &str, last: &str) -> String {
    format!(
        "{functions}
         static const pliant_material own = {{sizeof(pliant_material), elements, rest, mass, energy, {last}, NULL, NULL}};
         static const void *other(const pliant_plugin *p, const char *id) {{
           (void)p; return strcmp(id, PLIANT_MATERIAL) == 0 ? &own : NULL; }}
         {}",
        create_with("it->plugin.extension = other;")
    )
}

/// Names of the failed cases.
fn failed(ran: &Ran) -> Vec<String> {
    let document = ran.json();
    let cases = document["cases"].as_array().expect("cases");
    let failed = cases.iter().filter(|c| c["verdict"] == "FAILED");
    failed.map(|c| c["case"].as_str().expect("a name").to_owned()).collect()
}

/// The case that puts arrays next to guard pages.
const PAGES: &str = "pages-around-arrays-are-left-alone";

/// What is said of the faults that only that case finds.
const SAID_OF_PAGES: [(&str, &str); 3] = [
    ("looks_behind", "`forces` of links 0 to 125 touched `x` behind its last value"),
    ("looks_before", "`forces` of links 0 to 125 touched `x` before its first value"),
    ("writes_same", "`forces` of links 0 to 125 touched `out` behind its last value"),
];

#[test]
#[cfg_attr(not(unix), ignore = "needs a C compiler with the options of GNU and Clang")]
fn each_violation_of_the_interface_fails_its_case_and_no_other() {
    let bench = Bench::new();
    let twice = format!(
        "static pliant_descriptor copies[2];
         static uint32_t calls;
         static const pliant_descriptor *alternating(uint32_t index) {{
           pliant_descriptor *copy = &copies[calls++ & 1];
           if (index > 0) return NULL;
           *copy = descriptor;
           copy->flags += calls & 1 ? 0u : 4u;
           return copy;
         }}
         static const pliant_plugin *faulty(const pliant_host *host, const char *id) {{ return create(host, id); }}
         {}",
        ENTRY.replace("describe_plugin", "alternating")
    );
    let any_id = format!(
        "static const pliant_plugin *faulty(const pliant_host *host, const char *id) {{
           (void)id;
           return create(host, descriptor.id);
         }}
         {ENTRY}"
    );
    let slow = format!(
        "#include <time.h>
         static pliant_status slow_init(const pliant_host *host, const char *folder) {{
           const clock_t start = clock();
           while (clock() - start < CLOCKS_PER_SEC / 4) (void)host, (void)folder;
           return init(host, folder);
         }}
         static const pliant_plugin *faulty(const pliant_host *host, const char *id) {{ return create(host, id); }}
         {}",
        ENTRY.replace(" init,", " slow_init,")
    );
    let any_extension = "static const void *any(const pliant_plugin *p, const char *id) {
           (void)p, (void)id;
           return &table;
         }
         ";
    let takes_all = "static pliant_status takes(const pliant_plugin *p, uint32_t index, double value) {
           if (index < PARAMS) ((instance *)p->data)->values[index] = value;
           return PLIANT_OK;
         }
         ";
    let with = |function: &str, change: &str| format!("{function}{}", create_with(change));
    let table = [
        ("slow", slow, "opens-under-100-ms"),
        ("twice", twice, "descriptor-is-stable"),
        ("any_id", any_id, "unknown-id-is-refused"),
        ("any_extension", with(any_extension, "it->plugin.extension = any;"), "unknown-extension-is-not-offered"),
        ("takes_all", with(takes_all, "it->plugin.set_number = takes;"), "out-of-range-is-refused"),
        ("reads_past", with_material(READS_PAST, "wide, tangent"), "planes-are-kept-to"),
        (
            "writes_measure",
            with_material(WRITES_MEASURE, "forces, tangent").replace(" energy,", " writing,"),
            "arrays-are-kept-to",
        ),
        ("looks_behind", with_material(&looks("3 * b->nodes"), "looking, tangent"), PAGES),
        ("looks_before", with_material(&looks("-1"), "looking, tangent"), PAGES),
        ("writes_same", with_material(WRITES_SAME, "same, tangent"), PAGES),
        ("runs_dry", with("static int opened;\n", "if (++opened > 30) return NULL;"), "opens-many-times"),
    ];
    for (stem, fault, case) in table {
        let library = compile_with_fault(&bench, stem, &fault);
        let ran = bench.pliant(&["plugin", "check", &library, "--json"]).expect(1);
        // What lies outside of an array and changes results is found at a page too.
        let also: &[&str] = if stem == "reads_past" { &[PAGES] } else { &[] };
        assert_eq!(failed(&ran), [&[case], also].concat(), "{stem}");
        if let Some((_, said)) = SAID_OF_PAGES.iter().find(|(name, _)| *name == stem) {
            assert!(ran.out.contains(said) && ran.out.contains("signal"), "{stem}: {}", ran.out);
        }
    }
    let library = compile_with_fault(&bench, "sound_after_all", &create_with(""));
    assert_eq!(failed(&bench.pliant(&["plugin", "check", &library, "--json"]).expect(0)), [""; 0]);
    // A plugin that does not open with its defaults.
    let refuses = "static pliant_status no(const pliant_plugin *p, const pliant_limits *l) { (void)l; \
                   return fail(p, PLIANT_BAD_ARGUMENT, \"not today\"); }\n";
    let library =
        compile_with_fault(&bench, "refuses", &format!("{refuses}{}", create_with("it->plugin.activate = no;")));
    let ran = bench.pliant(&["plugin", "check", &library, "--case", "opens-with-defaults", "--json"]).expect(1);
    assert_eq!(failed(&ran), ["opens-with-defaults"]);
    assert!(ran.out.contains("not today"), "the plugin's own reason: {}", ran.out);
}

#[test]
#[cfg_attr(not(all(target_os = "linux", target_env = "gnu")), ignore = "counts calls of glibc")]
fn allocations_of_a_c_plugin_are_found_where_they_are_counted() {
    let bench = Bench::new();
    let allocates = compile_with_fault(&bench, "allocates", &with_material(ALLOCATES, "allocating, tangent"));
    let count = std::fs::read_to_string(bench.path("sound/tests/count-malloc.c")).expect("a file of the project");
    let count = bench.compile("lib", "count_malloc", &count).display().to_string();
    let sound = compile_with_fault(&bench, "allocates_not", &create_with(""));
    let case = ["--case", "no-allocation-in-a-step"];
    let check = |library: &str, preload: &str| {
        let args = [&["plugin", "check", library, "--json"], &case[..]].concat();
        bench.pliant_with(&args, &[("LD_PRELOAD", preload)])
    };
    let ran = check(&allocates, &count).expect(1);
    assert!(ran.out.contains("`forces` allocated 1 times"), "{}", ran.out);
    assert_eq!(check(&sound, &count).expect(0).json()["ok"], 1);
    let uncounted = check(&allocates, "").expect(0).json();
    assert_eq!(uncounted["skipped"], 1, "{uncounted}");
    // A destroy that does not free the instance.
    let keeps = "static void keep(const pliant_plugin *p) { (void)p; }\n";
    let leaks = compile_with_fault(&bench, "leaks", &format!("{keeps}{}", create_with("it->plugin.destroy = keep;")));
    let ran = bench.pliant_with(&["plugin", "check", &leaks, "--json"], &[("LD_PRELOAD", &count)]).expect(1);
    assert_eq!(failed(&ran), ["memory-is-given-back"]);
    assert!(ran.out.contains("4 instances that were made and destroyed left 4 allocations behind"), "{}", ran.out);
}

/// Compiles a material whose `forces` runs the C statements `how`, which crash or never end.
fn compile_crashing(bench: &Bench, stem: &str, how: &str) -> String {
    let fault = format!(
        "static pliant_status crash(const pliant_plugin *p, const pliant_batch *b, double *f) {{
           static volatile int count; (void)p, (void)b, (void)f;
           {how}
           return count ? PLIANT_OK : PLIANT_IO;
         }}
         static const pliant_material crashing = {{sizeof(pliant_material), elements, rest, mass, energy, crash, tangent, NULL, NULL}};
         static const void *other(const pliant_plugin *p, const char *id) {{
           (void)p; return strcmp(id, PLIANT_MATERIAL) == 0 ? &crashing : NULL; }}
         {}",
        create_with("it->plugin.extension = other;")
    );
    compile_with_fault(bench, stem, &fault)
}

#[test]
#[cfg_attr(not(unix), ignore = "needs a C compiler with the options of GNU and Clang")]
fn a_case_that_crashes_or_hangs_fails_and_the_others_run() {
    let bench = Bench::new();
    for (stem, how, said) in [
        ("segfault", "*(volatile int *)(size_t)count = 1;", "signal 11 (segmentation fault)"),
        ("abort", "abort();", "signal 6 (abort)"),
        ("hangs", "for (;;) count++;", "did not end within 1 s"),
        ("exits", "exit(0);", "ended the program with `exit`"),
    ] {
        let library = compile_crashing(&bench, stem, how);
        let (case, seconds) = (["--case", "rest-is-force-free"], ["--seconds", "1"]);
        let ran = bench.pliant(&[["plugin", "check"], [&library, "--json"], case, seconds].concat()).expect(1);
        assert!(ran.out.contains(said), "{stem}: {}", ran.out);
        bench.pliant(&["plugin", "check", &library, "--case", "mass-is-positive"]).expect(0);
    }
}

#[test]
fn files_that_are_no_plugin_end_the_check_with_a_message() {
    let bench = Bench::new();
    let text = bench.write("no.so", "not a library").display().to_string();
    bench.pliant(&["plugin", "check", &text]).expect(3).says(&["no.so", "cannot be opened as a shared library"]);
    bench.pliant(&["plugin", "check", "nowhere/at/all.so"]).expect(3);
    bench.pliant(&["plugin", "check", "mass-spring", "--case", "no-such-case"]).expect(2);
    bench.pliant(&["plugin", "check", "mass-spring", "--case", "mass-is-positive"]).expect(0);
}

#[test]
#[cfg_attr(not(unix), ignore = "needs a C compiler with the options of GNU and Clang")]
fn a_crash_in_an_isolated_run_is_an_error_of_the_run() {
    let bench = Bench::new();
    compile_crashing(&bench, "sound", "*(volatile int *)(size_t)count = 1;");
    let ran = bench.pliant(&["run", "sound/scene.toml", "--isolate", "--plugin-path", "lib", "--out", "out"]);
    let ran = ran.expect(3).says(&["segmentation fault", "`forces` of plugin `sound`", "crashed"]);
    assert!(ran.out.is_empty() && !bench.path("out/final.obj").exists(), "{}", ran.out);
    // Without a crash an isolated run ends like any other.
    let ran = ["run", "sound/scene.toml", "--isolate", "--set", "body.0.material.plugin=mass-spring", "--out", "well"];
    bench.pliant(&ran).expect(0);
    assert!(bench.path("well/final.obj").is_file());
    bench.pliant(&["run", "nothing.toml", "--isolate"]).expect(2).says(&["nothing.toml"]);
}
