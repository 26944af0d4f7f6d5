// What was checked, and how it went.

export class Results {
  passed = 0;
  failed = 0;

  /** Counts one check. Only a failed one is printed. */
  check(isRight, what) {
    if (isRight) {
      this.passed += 1;
    } else {
      this.failed += 1;
      console.log(`  FAILED: ${what}`);
    }
    return isRight;
  }

  /** Runs `body`. What it throws is a failed check, so that one bad file does not hide the others. */
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
