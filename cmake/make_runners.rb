# ruby make_runners.rb GENERATOR CONFIG FOLDER TEST.c...: FOLDER/TEST_runner.c of every test file, by Unity's generator.
# One Ruby for all of them: starting it takes three times as long as one runner. A runner that stays the same is not touched.
generator, config, folder, *tests = ARGV
require generator

tests.each do |test|
  runner = File.join(folder, "#{File.basename(test, '.c')}_runner.c")
  made = "#{runner}.new"
  UnityTestRunnerGenerator.new(UnityTestRunnerGenerator.grab_config(config)).run(test, made)
  if File.exist?(runner) && File.binread(runner) == File.binread(made)
    File.delete(made)
  else
    File.rename(made, runner)
  end
end
