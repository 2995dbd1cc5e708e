//! Locks every file that a render will write, so that two renders never work towards the same file.

use crate::error::{Error, Field};
use crate::job::Job;
use files::lock::Lock;
use files::paths;
use std::path::Path;

/// Locks the outputs with their snapshots and the checkpoint of `job`, besides what it has locked already.
pub(crate) fn lock(job: &mut Job) -> Result<Vec<Lock>, Error> {
    let mut locks = Vec::from_iter(job.lock.take());
    let outputs = job.outputs.files().map(|(content, path)| (content.field(), path));
    let checkpoint = job.save.iter().map(|save| (Field::Checkpoint, save.path.as_path()));
    let snapshots: Vec<_> = job.outputs.all_snapshots(job.scene.settings.iterations).collect();
    let snapshots = snapshots.iter().map(|path| (Field::Snapshots, path.as_path()));
    let mut files: Vec<(Field, &Path)> = outputs.chain(checkpoint).chain(snapshots).collect();
    // All renders lock in the same order, so that of those that share several files one gets them all.
    files.sort_by_key(|(_, path)| paths::identity(path));
    for (field, path) in files {
        if !locks.iter().any(|lock| lock.is_of(path)) {
            locks.push(Lock::take(path).map_err(|error| Error::named(field, error))?);
        }
    }
    Ok(locks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::save::{Every, Save};

    /// Whatever each of them is for.
    #[test]
    fn files_are_locked_in_the_order_of_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b, c] = ["a.pfm", "b.pfm", "c.pfm"].map(|name| folder.path().join(name));
        for [image, radius, checkpoint] in [[&a, &b, &c], [&c, &b, &a], [&b, &c, &a]] {
            let mut job = Job::new(files::builtin::scene("cornell").unwrap());
            (job.outputs.image, job.outputs.radius_image) = (Some(image.clone()), Some(radius.clone()));
            job.save = Some(Save { path: checkpoint.clone(), every: Every::default(), keep: true });
            let locks = lock(&mut job).unwrap();
            assert_eq!(locks.len(), 3);
            assert!(locks.iter().zip([&a, &b, &c]).all(|(lock, path)| lock.is_of(path)), "{locks:?}");
        }
    }
}
