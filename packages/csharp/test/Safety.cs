// Bad files, handles that are given back, and loops that allocate nothing.

using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using Vademecum;

internal static class Safety
{
    private static void Expect(bool holds, string what)
    {
        if (!holds)
        {
            Console.Error.WriteLine("Safety.cs: " + what);
            Environment.Exit(1);
        }
    }

    private static void Refused<T>(string what, Action call, string words = "") where T : Exception
    {
        try
        {
            call();
        }
        catch (T refusal)
        {
            Expect(refusal.Message.Contains(words), what + ": expected `" + words + "`, found `" + refusal.Message + "`");
            return;
        }
        Expect(false, what + " was not refused");
    }

    /// <summary>Every cut of a file, and a thousand with a changed byte: a body, or an exception.</summary>
    private static void BadFiles(byte[] good)
    {
        Refused<VademecumException>("no file", () => new BodyFile(new byte[0]).Bind(), "0 bytes");
        Refused<VademecumException>("a text", () => new BodyFile(new byte[4096]).Bind());
        Refused<FileNotFoundException>("a path", () => BodyFile.Open("nowhere.vdm"));
        int refused = 0;
        for (int length = 0; length < good.Length; length += 7)
        {
            var cut = new byte[length];
            Array.Copy(good, cut, length);
            Refused<VademecumException>("a cut file", () => new BodyFile(cut).Bind());
            refused++;
        }
        var random = new Random(1);
        int bound = 0;
        for (int i = 0; i < 1000; i++)
        {
            var changed = (byte[])good.Clone();
            changed[random.Next(changed.Length)] ^= (byte)(1 + random.Next(255));
            using (var file = new BodyFile(changed))
            {
                try
                {
                    using (var body = file.Bind())
                    {
                        body.Step(3);
                        bound++;
                    }
                }
                catch (VademecumException)
                {
                    refused++;
                }
            }
        }
        Console.WriteLine("bad files: {0} refused, {1} stepped", refused, bound);
    }

    /// <summary>Bytes of memory that this process holds.</summary>
    private static long Resident()
    {
        GC.Collect();
        GC.WaitForPendingFinalizers();
        GC.Collect();
        return 4096 * long.Parse(File.ReadAllText("/proc/self/statm").Split(' ')[1], CultureInfo.InvariantCulture);
    }

    private static void Handles(byte[] good)
    {
        var file = new BodyFile(good);
        var body = file.Bind();
        file.Dispose();
        Refused<ObjectDisposedException>("a file that was given back", () => file.Bind());
        body.Step(1);
        var place = body.AtNode(1);
        uint[] nodes;
        double[] weights;
        place.Read(out nodes, out weights);
        Expect(nodes.Length == 1 && weights[0] == 1.0, "a node is a place of one node");
        var made = new Place(nodes, weights);
        body.Push(ref made, new Vector(1, 2, 3));
        var nowhere = new Place(new uint[] { 1000000 }, new[] { 1.0 });
        Refused<VademecumException>("a place that is not there", () => body.Push(ref nowhere, new Vector(1, 2, 3)));
        Refused<VademecumException>("a force", () => body.Push(ref made, new Vector(double.NaN, 0, 0)), "finite");
        Refused<VademecumException>("a short array", () => body.Surface(new float[1]));
        Refused<NullReferenceException>("no array", () => body.Surface((float[])null));
        Refused<VademecumException>("a name", () => body.Find(Named.Probes, "nowhere"), "nowhere");
        Refused<ArgumentException>("arrays of two lengths", () => body.Set(new double[1], new double[2]));
        Refused<VademecumException>("a state", () => body.Restore(new byte[10]));
        Expect(body.Name(Named.Probes, body.Find(Named.Probes, "y")) == "y", "names are found");
        Expect(Quantity.All().Length > 10 && Quantity.All()[Quantity.Find("energy")].Unit == "J", "the table of quantities");
        Expect(body.Read(Quantity.Find("energy"))[0] == body.Energy(), "a quantity by its number");
        var saved = body.Save();
        body.Step(5);
        var after = body.Save();
        Expect(body.Restore(saved), "a state is taken back bit by bit");
        body.Step(5);
        Expect(Convert.ToBase64String(body.Save()) == Convert.ToBase64String(after), "it goes on bit by bit");

        // A world keeps its bodies while it is there.
        var one = new Member { Body = body };
        Refused<VademecumException>("a world", () => new World(new[] { one }, new[] { new Pair { Second = 9 } }, new Joint[0],
            WorldOptions.Default));
        var world = new World(new[] { one }, new Pair[0], new Joint[0], WorldOptions.Default);
        body.Dispose();
        Refused<ObjectDisposedException>("a body that only its world has", () => body.Step(1));
        world.Step(3);
        world.Dispose();
        Refused<ObjectDisposedException>("a world that was given back", () => world.Step(1));
        Refused<ObjectDisposedException>("a body that was given back", () => body.Step(1));
        body.Dispose();

        // Given back by Dispose, by the collector, and where binding fails.
        Action<bool> make = dispose =>
        {
            var again = new BodyFile(good);
            var moving = again.Bind();
            moving.Step(1);
            Refused<VademecumException>("a precision", () => again.Bind(new BodyOptions { Precision = (Precision)7 }));
            if (dispose)
            {
                moving.Dispose();
                again.Dispose();
            }
        };
        for (int i = 0; i < 500; i++)
        {
            make(true);
        }
        long before = Resident();
        const int Times = 4000;
        for (int i = 0; i < Times; i++)
        {
            make(i % 2 == 0);
        }
        long grown = Resident() - before, held = (long)Times * good.Length;
        Console.WriteLine("{0} files and bodies: {1} KB more, of {2} KB in their files alone", Times, grown / 1024, held / 1024);
        Expect(grown < held / 4, "memory was not given back");
    }

    private static void NothingIsAllocated(byte[] good)
    {
        using (var file = new BodyFile(good))
        using (var body = file.Bind())
        {
            var place = body.AtNode(2);
            var surface = new float[3 * body.Counts.SurfaceNodes];
            Action loop = () =>
            {
                for (int i = 0; i < 1000; i++)
                {
                    body.Clear();
                    body.Push(ref place, new Vector(0, 0, 1e-3 * i));
                    body.Step();
                    body.Point(ref place);
                    body.Probe(0);
                    body.Energy();
                    body.Surface(surface);
                }
            };
            loop();
            GC.Collect();
            long before = GC.GetTotalMemory(false);
            for (int i = 0; i < 100; i++)
            {
                loop();
            }
            long more = GC.GetTotalMemory(false) - before;
            Expect(more < 100000, "100 000 steps allocated " + more + " bytes");
            var watch = System.Diagnostics.Stopwatch.StartNew();
            for (int i = 0; i < 100000; i++)
            {
                body.Step();
            }
            Console.WriteLine("100 000 steps, pushed and read: {0} bytes more; a call of Step takes {1:0} ns under Mono", more,
                1e4 * watch.Elapsed.TotalMilliseconds / 1e3);
        }
    }

    /// <summary>The columns of `vademecum run`, digit for digit.</summary>
    private static void LikeTheProgram(byte[] good, string csv)
    {
        var options = BodyOptions.Default;
        options.Precision = Precision.Double;
        using (var file = new BodyFile(good))
        using (var body = file.Bind(options))
        {
            var place = body.Locate(new Vector(0, 0, 0));
            body.Push(ref place, new Vector(1.0, -2.0, 3.0));
            var lines = new List<string>(File.ReadAllLines(csv));
            Expect(lines.Count == 22, "the run has 21 rows");
            for (int row = 2; row < lines.Count; row++)
            {
                body.Step();
                var cells = lines[row].Split(',');
                for (int i = 1; i < cells.Length; i++)
                {
                    double value = i == 1 ? body.Energy() : body.Probe(i - 2);
                    var text = value.ToString("0.000000000e0", CultureInfo.InvariantCulture);
                    Expect(text == cells[i], "row " + row + ": `run` has " + cells[i] + ", C# " + text);
                }
            }
            Console.WriteLine("{0} rows of `vademecum run`, digit for digit", lines.Count - 2);
        }
    }

    private static int Main(string[] arguments)
    {
        var good = File.ReadAllBytes(arguments[0]);
        BadFiles(good);
        Handles(good);
        NothingIsAllocated(good);
        LikeTheProgram(good, arguments[1]);
        return 0;
    }
}
