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
