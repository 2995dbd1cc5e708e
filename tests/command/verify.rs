//! The command `verify` on equal engines. Unit tests check that it finds differences.

use crate::sandbox::{Ended, Sandbox, TINY};

#[test]
fn identical_engines_are_reported_for_all_lanes_and_threads() {
    let sandbox = Sandbox::new();
    for scene in ["cornell", "motion"] {
        let Ended { code, stdout, stderr } =
            sandbox.run(["verify", scene, "--threads", "3"].iter().chain(&TINY));
        assert_eq!((code, stderr.as_str()), (Some(0), ""));
        let words = [
            "identical",
            "16 x 12 pixels",
            "2 iterations",
            "grid cells of 3.7 radii",
            "emulated lanes and 1 thread\n",
        ];
        for words in words {
            assert!(stdout.contains(words), "no {words:?} in {stdout}");
        }
        let kinds = fast::LaneKind::ALL.into_iter().filter(|kind| kind.is_available()).count();
        assert_eq!(stdout.matches("lanes and 1 thread\n").count(), kinds, "{stdout}");
        assert_eq!(stdout.matches("lanes and 3 threads\n").count(), kinds, "{stdout}");
    }
    assert_eq!(sandbox.names(), [""; 0]);
}

#[test]
fn the_path_tracers_are_compared_too() {
    let ended =
        Sandbox::new().run(["verify", "motion", "--method", "path", "--threads", "2"].iter().chain(&TINY));
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
    let kinds = fast::LaneKind::ALL.into_iter().filter(|kind| kind.is_available()).count();
    assert_eq!(ended.stdout.matches("fast on ").count(), 2 * kinds, "{ended:?}");
    assert!(ended.stdout.contains("bit of the path tracer's image"), "{ended:?}");
    assert!(!ended.stdout.contains("grid cells"), "{ended:?}");
}

/// On one core too, several threads are compared.
#[test]
fn by_itself_all_cores_are_used_and_at_least_two_threads() {
    let ended = Sandbox::new().run(["verify", "cornell", "--method", "path"].iter().chain(&TINY));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let most = std::thread::available_parallelism().map_or(1, usize::from).max(2);
    let kinds = fast::LaneKind::ALL.into_iter().filter(|kind| kind.is_available()).count();
    for threads in ["1 thread\n".to_owned(), format!("{most} threads\n")] {
        assert_eq!(ended.stdout.matches(&format!(" lanes and {threads}")).count(), kinds, "{ended:?}");
    }
}

#[test]
fn one_thread_is_run_once() {
    let ended = Sandbox::new().run(["verify", "cornell", "--threads", "1"].iter().chain(&TINY));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert_eq!(ended.stdout.matches("emulated lanes").count(), 1, "{ended:?}");
}
