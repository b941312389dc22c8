// c++ -std=c++17 response.cpp -o response $(pkg-config --cflags --libs vibroimpact)
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vibroimpact.h>

// A result that frees itself; a case that is wrong is an exception.
class Result {
public:
    explicit Result(const std::string &text, int threads = 0)
    {
        if (vibroimpact_run(text.c_str(), threads, nullptr, &handle) == VIBROIMPACT_WRONG) {
            std::string message = this->text(VIBROIMPACT_MESSAGE);
            vibroimpact_free(handle);
            throw std::invalid_argument(message);
        }
    }
    ~Result() { vibroimpact_free(handle); }
    Result(const Result &) = delete;
    Result &operator=(const Result &) = delete;

    std::string text(int what) const
    {
        std::string out(vibroimpact_text(handle, what, nullptr, 0), '\0');
        vibroimpact_text(handle, what, out.data(), out.size() + 1);
        return out;
    }
    struct vibroimpact_column column(const char *table, const char *name) const
    {
        struct vibroimpact_column found;
        if (vibroimpact_find(handle, table, name, &found) != VIBROIMPACT_DONE)
            throw std::out_of_range(name);
        return found;
    }

private:
    vibroimpact_result handle = 0;
};

int main()
{
    const Result result("&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n"
                        "&response r_min = 1.00, r_max = 1.04, r_points = 5, clearance = 25, states = 6 /\n");
    const auto r = result.column("points", "r");
    const auto lowest = result.column("points", "lowest"), highest = result.column("points", "highest");
    for (int i = 0; i < r.shape[0]; i++)
        std::printf("%.2f %.10f %.10f\n", r.x[i], lowest.x[i], highest.x[i]);
    std::fputs(result.text(VIBROIMPACT_FAULTS).c_str(), stderr);
}
