//! The command `verify`. That it finds differences is tested beside it, on engines that differ.

use crate::sandbox::{Ended, Sandbox, TINY};

#[test]
fn the_reference_equals_itself_on_other_grids_and_says_so() {
    let sandbox = Sandbox::new();
    for scene in ["cornell", "mirror"] {
        let Ended { code, stdout, stderr } = sandbox.run(["verify", scene].iter().chain(&TINY));
        assert_eq!((code, stderr.as_str()), (Some(0), ""));
        for words in
            ["identical", "16 x 12 pixels", "2 iterations", "grid cells of 1 radius", "compared with itself"]
        {
            assert!(stdout.contains(words), "no {words:?} in {stdout}");
        }
    }
    assert_eq!(sandbox.names(), [""; 0]);
}
