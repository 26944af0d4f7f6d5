// Counts checks and their results.

export class Results {
  passed = 0;
  failed = 0;

  /** Counts one check, and prints it if it failed. */
  check(isRight, what) {
    if (isRight) {
      this.passed += 1;
    } else {
      this.failed += 1;
      console.log(`  FAILED: ${what}`);
    }
    return isRight;
  }

  /** Runs `body`. An exception counts as a failed check, so that one bad file does not stop the other checks. */
  async guard(what, body) {
    try {
      await body();
    } catch (error) {
      this.check(false, `${what}: ${error.stderr?.toString().trim() || error.stack}`);
    }
  }

  note(text) {
    console.log(`  ${text}`);
  }
}
